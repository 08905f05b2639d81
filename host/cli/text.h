// Numbers as people read them, under the command line's own name.
#pragma once

#include "host/pipeline/text.h"

namespace fascicle::cli {

using pipeline::bits_text;
using pipeline::bytes_text;
using pipeline::columns_text;
using pipeline::count_text;
using pipeline::duration_text;
using pipeline::float_text;
using pipeline::number_text;

}  // namespace fascicle::cli
