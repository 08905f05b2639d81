// A batch as a job template of Open Job Description, for farms that read those.
#pragma once

#include <filesystem>

#include "host/cli/farm_tasks.h"

namespace fascicle::cli {

// Writes the template, of the specification's version 2023-09, whole: as JSON, or with a comment at its head
// where the file is called .yaml or .yml, as JSON is YAML. Throws UsageError for another name, and for a path
// that the specification does not allow.
void write_openjd_template(const std::filesystem::path& file, const FarmBatch& batch);

}  // namespace fascicle::cli
