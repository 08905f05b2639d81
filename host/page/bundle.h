// The pages from web/, bundled by esbuild into web/bundle.
#pragma once

#include <string_view>

namespace fascicle::page {

// A complete HTML page with marks where a title and a bake go (bake_page.cpp).
std::string_view view_bundle();

}  // namespace fascicle::page
