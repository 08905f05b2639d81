// The pages from web/, bundled by esbuild into web/bundle.
#pragma once

#include <string_view>

namespace fascicle::page {

// A complete HTML page with placeholders for a title and a bake (bake_page.cpp).
std::string_view view_bundle();

}  // namespace fascicle::page
