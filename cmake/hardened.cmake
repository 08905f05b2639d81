# What makes the programs harder to break into, and their bytes the same from every folder; tests/house/hardened.py
# looks for it in what was built. No flag here touches floating point. The options hold for the targets made after
# this file, until hardened_end(): tests go without. A sanitizer checks the same and more, and does not go together
# with _FORTIFY_SOURCE.
include(CheckCXXCompilerFlag)
include(CheckPIESupported)
check_pie_supported()

set(FASCICLE_HARDENED OFF)
if(NOT FASCICLE_SANITIZE)
  set(FASCICLE_HARDENED ON)
  set(optimised $<CONFIG:Release,RelWithDebInfo,MinSizeRel>)
  # Some distributions' compilers define it themselves, as 2 or 3. Here it is 2 everywhere, so that the same sources are
  # checked alike: 3 finds more sizes, but it needs g++ 12 or clang 9, and computes sizes while the program runs.
  add_compile_options($<${optimised}:-U_FORTIFY_SOURCE> $<${optimised}:-D_FORTIFY_SOURCE=2>)
  # -fcf-protection is of x86 alone.
  foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection)
    string(MAKE_C_IDENTIFIER "FASCICLE_HAS${flag}" has)
    check_cxx_compiler_flag(${flag} ${has})
    if(${has})
      add_compile_options($<${optimised}:${flag}>)
    endif()
  endforeach()
  add_link_options(LINKER:-z,relro,-z,now,-z,noexecstack)
  # Two mappings. The build folder comes second, because it may lie within the source folder, and the compiler takes the
  # last mapping that matches. Debug builds keep the paths, which a debugger needs to find the sources.
  foreach(renamed "${CMAKE_SOURCE_DIR}=." "${CMAKE_BINARY_DIR}=build")
    add_compile_options("$<$<CONFIG:Release,MinSizeRel>:-ffile-prefix-map=${renamed}>")
  endforeach()
  # A run path in the build folder begins at the file's own place.
  set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)
endif()

function(hardened_end)
  set_directory_properties(PROPERTIES COMPILE_OPTIONS "" LINK_OPTIONS "")
endfunction()
