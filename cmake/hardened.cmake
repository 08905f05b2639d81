# Hardens the programs, and makes their bytes independent of the build folder; tests/house/hardened.py checks the
# built files. No flag here affects floating point. The options apply to targets created after this file, until
# hardened_end(): tests are excluded. Sanitizers check the same and more, and are incompatible with _FORTIFY_SOURCE.
include(CheckCXXCompilerFlag)
include(CheckPIESupported)

set(FASCICLE_HARDENED OFF)
if(NOT FASCICLE_SANITIZE)
  set(FASCICLE_HARDENED ON)
  check_pie_supported()
  set(optimised $<CONFIG:Release,RelWithDebInfo,MinSizeRel>)
  # Some distributions' compilers predefine it as 2 or 3. We use 2 everywhere, so that the same sources get the same
  # checks: 3 determines more sizes, but needs g++ 12 or clang 9 and computes sizes at run time.
  add_compile_options($<${optimised}:-U_FORTIFY_SOURCE> $<${optimised}:-D_FORTIFY_SOURCE=2>)
  # -fcf-protection exists only on x86.
  foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection)
    string(MAKE_C_IDENTIFIER "FASCICLE_HAS${flag}" has)
    check_cxx_compiler_flag(${flag} ${has})
    if(${has})
      add_compile_options($<${optimised}:${flag}>)
    endif()
  endforeach()
  add_link_options(LINKER:-z,relro,-z,now,-z,noexecstack)
  # Two mappings. The build folder comes second, because it may be inside the source folder, and the compiler uses the
  # last mapping that matches. Debug builds keep the paths, which a debugger needs to find the sources, and so do
  # builds that count lines: gcovr leaves a unit out if it does not find each of its sources.
  if(NOT FASCICLE_COVERAGE)
    foreach(renamed "${CMAKE_SOURCE_DIR}=." "${CMAKE_BINARY_DIR}=build")
      add_compile_options("$<$<CONFIG:Release,MinSizeRel>:-ffile-prefix-map=${renamed}>")
    endforeach()
  endif()
  # Run paths in the build folder are relative to the file.
  set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)
endif()

function(hardened_end)
  set_directory_properties(PROPERTIES COMPILE_OPTIONS "" LINK_OPTIONS "")
endfunction()
