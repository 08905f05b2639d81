# The portable pair, for any distribution: `fascicle`, which needs only the C library, and `fascicle-mesher`, with its
# libraries in the same folder. Both are linked from the objects of the usual programs, into the folder portable.
set(pair_folder ${CMAKE_BINARY_DIR}/portable)

# Debian's static libraries, so that the executable does not need the shared ones.
foreach(library z png jpeg)
  find_library(FASCICLE_ARCHIVE_${library} lib${library}.a REQUIRED)
  add_library(fascicle_${library}_archive INTERFACE)
  target_link_libraries(fascicle_${library}_archive INTERFACE ${FASCICLE_ARCHIVE_${library}})
endforeach()
target_link_libraries(fascicle_png_archive INTERFACE fascicle_z_archive)

# Debian has TetGen only as a shared library, which needs the shared C++ library. A portable mesher has all of them in
# its folder. DT_RPATH instead of DT_RUNPATH, because it also applies to the libraries that TetGen needs.
add_executable(mesher_portable $<TARGET_OBJECTS:fascicle-mesher>)
set_target_properties(mesher_portable PROPERTIES
  OUTPUT_NAME fascicle-mesher RUNTIME_OUTPUT_DIRECTORY ${pair_folder} LINKER_LANGUAGE CXX BUILD_RPATH "$ORIGIN")
target_link_libraries(mesher_portable PRIVATE ${TETGEN_LIBRARY} ${MPFR_LIBRARY} ${GMP_LIBRARY})
target_link_options(mesher_portable PRIVATE -Wl,--disable-new-dtags)
add_custom_command(TARGET mesher_portable POST_BUILD
  COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:mesher_portable> -P ${CMAKE_SOURCE_DIR}/cmake/libraries_beside.cmake
  COMMENT "Copying the mesher's libraries beside it" VERBATIM)

add_executable(fascicle_portable $<TARGET_OBJECTS:fascicle>)
set_target_properties(fascicle_portable PROPERTIES
  OUTPUT_NAME fascicle RUNTIME_OUTPUT_DIRECTORY ${pair_folder} LINKER_LANGUAGE CXX FASCICLE_PORTABLE ON)
target_link_libraries(fascicle_portable PRIVATE fascicle_cli)
add_dependencies(fascicle_portable mesher_portable)

find_program(READELF readelf REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)

# The contents of the pair, as in the packages (cmake/install.cmake).
set(pair_contents ${pair_folder}/fascicle.spdx.json)
add_custom_command(OUTPUT ${pair_contents}
  COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/cmake/sbom.py --name fascicle-portable
    --version ${PROJECT_VERSION} --in program,mesher --without assimp --source ${CMAKE_SOURCE_DIR} --strict
    --prefix ${pair_folder} --output ${pair_contents} -- $<TARGET_FILE:fascicle_portable>
    $<TARGET_FILE:mesher_portable> ${pair_folder}/libtet.so.1.5 ${pair_folder}/libstdc++.so.6
    ${pair_folder}/libgcc_s.so.1
  DEPENDS fascicle_portable mesher_portable ${CMAKE_SOURCE_DIR}/cmake/sbom.py ${CMAKE_SOURCE_DIR}/docs/licences.md
    ${CMAKE_SOURCE_DIR}/web/package-lock.json
  COMMENT "Listing what is in the portable pair" VERBATIM)
add_custom_target(portable_contents ALL DEPENDS ${pair_contents})
set(needed_check ${CMAKE_COMMAND} -D READELF=${READELF} -P ${CMAKE_SOURCE_DIR}/tests/house/needed.cmake --)
add_test(NAME house.portable_fascicle_needs_only_the_c_library
  COMMAND ${needed_check} $<TARGET_FILE:fascicle_portable>)
add_test(NAME house.portable_mesher_needs_only_its_libraries_beside
  COMMAND ${needed_check} $<TARGET_FILE:mesher_portable> libtet.so.1.5 libstdc++.so.6 libgcc_s.so.1)
add_test(NAME house.portable_bakes_a_character_in_an_empty_root
  COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/tests/house/empty_root.py $<TARGET_FILE:fascicle_portable>)
add_test(NAME house.portable_pair_lists_what_is_in_it
  COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/tests/house/portable_contents.py ${pair_folder})
set_tests_properties(house.portable_fascicle_needs_only_the_c_library house.portable_pair_lists_what_is_in_it
  house.portable_mesher_needs_only_its_libraries_beside house.portable_bakes_a_character_in_an_empty_root
  PROPERTIES LABELS short TIMEOUT 600)
if(FASCICLE_HARDENED AND CMAKE_BUILD_TYPE MATCHES "^(Release|MinSizeRel)$")
  add_test(NAME house.portable_pair_is_hardened
    COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/tests/house/hardened.py ${CMAKE_CXX_COMPILER}
      ${CMAKE_SOURCE_DIR} ${CMAKE_BINARY_DIR}/compile_commands.json
      $<TARGET_FILE:fascicle_portable> $<TARGET_FILE:mesher_portable>)
  set_tests_properties(house.portable_pair_is_hardened PROPERTIES LABELS short TIMEOUT 600)
endif()
