// Numbers and names in readable form, in the command line's namespace, and words quoted for shells.
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
using pipeline::counted_text;
using pipeline::duration_text;
using pipeline::float_text;
using pipeline::number_text;

// The text in single quotes, for a POSIX shell.
std::string in_quotes(const std::string& text);

// A word for a POSIX shell, quoted if necessary. Characters that control a terminal are written as $'\033'
// and the like (in POSIX since 2024, and long supported by bash, zsh and ksh), so that a command reads as
// what it does.
std::string shell_word(const std::string& word);

}  // namespace fascicle::cli
