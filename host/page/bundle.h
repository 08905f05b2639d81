// The pages that web/ holds, as esbuild bundled them into web/bundle.
#pragma once

#include <string_view>

namespace fascicle::page {

// A whole HTML page with one place for a title and one for a bake (bake_page.cpp).
std::string_view view_bundle();

}  // namespace fascicle::page
