// Writes a batch as a job template for farms that read Open Job Description.
#pragma once

#include <filesystem>

#include "host/cli/farm_tasks.h"

namespace fascicle::cli {

// Throws UsageError if the file exists and is not a template that --emit wrote.
void refuse_others_template(const std::filesystem::path& file);

// Atomically writes the template, version 2023-09 of the specification: as JSON, or with a leading comment if
// the file is named .yaml or .yml, since JSON is YAML. Throws UsageError for any other extension, and for a
// path that the specification does not allow.
void write_openjd_template(const std::filesystem::path& file, const FarmBatch& batch);

}  // namespace fascicle::cli
