// Numbers and names as people read them, under the command line's own name, and words as shells read them.
#pragma once

#include <string>

#include "host/base/text.h"
#include "host/pipeline/text.h"

namespace fascicle::cli {

using base::shown_text;
using pipeline::bits_text;
using pipeline::bytes_text;
using pipeline::columns_text;
using pipeline::count_text;
using pipeline::duration_text;
using pipeline::float_text;
using pipeline::number_text;

// Within '...' of a POSIX shell, or of fish.
std::string in_quotes(const std::string& text);

// A word for a POSIX shell, quoted where it must be. What a terminal would obey is written as $'\033' and the
// like, which POSIX has since 2024 and bash, zsh and ksh always had, so that a command reads as what it does.
std::string shell_word(const std::string& word);

}  // namespace fascicle::cli
