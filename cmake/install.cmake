# cmake --install: the programs, the shared library, and what other projects need to use it. Each file belongs to a
# component, which is also a Debian package (cmake/packages.cmake).
include(CMakePackageConfigHelpers)

install(TARGETS fascicle RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(TARGETS fascicle-mesher RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mesher)
if(TARGET fascicle-convert)
  install(TARGETS fascicle-convert RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

if(TARGET fascicle_library)
  set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/fascicle)
  install(TARGETS fascicle_library EXPORT fascicle_targets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
  install(FILES
    include/fascicle/export.h include/fascicle/fascicle.h include/fascicle/fascicle.hpp include/fascicle/solver.h
    include/fascicle/version.h
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fascicle COMPONENT development)
  install(EXPORT fascicle_targets NAMESPACE fascicle:: FILE fascicle-targets.cmake
    DESTINATION ${config_folder} COMPONENT development)
  configure_package_config_file(cmake/fascicle-config.cmake.in ${CMAKE_BINARY_DIR}/fascicle-config.cmake
    INSTALL_DESTINATION ${config_folder})
  # Before 1.0, each minor version may change the interface.
  write_basic_package_version_file(${CMAKE_BINARY_DIR}/fascicle-config-version.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_BINARY_DIR}/fascicle-config.cmake ${CMAKE_BINARY_DIR}/fascicle-config-version.cmake
    DESTINATION ${config_folder} COMPONENT development)
  # Relative to the file, so that a prefix may be moved.
  file(RELATIVE_PATH pc_prefix /p/${CMAKE_INSTALL_LIBDIR}/pkgconfig /p)
  configure_file(cmake/fascicle.pc.in ${CMAKE_BINARY_DIR}/fascicle.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/fascicle.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endif()

# The program itself generates the manual page and the completions.
set(manual_folder ${CMAKE_BINARY_DIR}/manual)
add_custom_command(
  OUTPUT ${manual_folder}/fascicle.1 ${manual_folder}/fascicle ${manual_folder}/_fascicle ${manual_folder}/fascicle.fish
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manual_folder}
  COMMAND fascicle manual man > ${manual_folder}/fascicle.1
  COMMAND fascicle manual bash > ${manual_folder}/fascicle
  COMMAND fascicle manual zsh > ${manual_folder}/_fascicle
  COMMAND fascicle manual fish > ${manual_folder}/fascicle.fish
  DEPENDS fascicle
  VERBATIM)
add_custom_target(fascicle_manual ALL DEPENDS ${manual_folder}/fascicle.1)
# Under /usr, zsh searches a different folder.
set(zsh_folder site-functions)
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(zsh_folder vendor-completions)
endif()
install(FILES ${manual_folder}/fascicle.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${manual_folder}/fascicle DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  COMPONENT program)
install(FILES ${manual_folder}/_fascicle DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/${zsh_folder} COMPONENT program)
install(FILES ${manual_folder}/fascicle.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)

# Every package contains its own licence. The program contains the browser pages, which include three.js; its notice
# is at the start of their script.
file(READ web/bundle/view.html page)
string(REGEX MATCH "three\\.js, https://threejs\\.org[^*]*" notice "${page}")
if(NOT notice MATCHES "MIT License")
  message(FATAL_ERROR "web/bundle/view.html has no notice of three.js; run ./do web")
endif()
file(READ LICENSE licence)
file(WRITE ${CMAKE_BINARY_DIR}/copyright_of_program "${licence}\n\nThe program contains ${notice}")
set(doc_folder ${CMAKE_INSTALL_DATADIR}/doc)
install(FILES ${CMAKE_BINARY_DIR}/copyright_of_program DESTINATION ${doc_folder}/fascicle RENAME copyright
  COMPONENT program)
install(FILES LICENSE DESTINATION ${doc_folder}/libfascicle${PROJECT_VERSION_MAJOR} RENAME copyright COMPONENT library)
install(FILES LICENSE DESTINATION ${doc_folder}/libfascicle-dev RENAME copyright COMPONENT development)
install(DIRECTORY docs/examples/library/ DESTINATION ${doc_folder}/libfascicle-dev/examples COMPONENT development)
install(FILES host/mesher/COPYING DESTINATION ${doc_folder}/fascicle-mesher RENAME copyright COMPONENT mesher)
if(TARGET fascicle_python)
  install(FILES LICENSE DESTINATION ${doc_folder}/python3-fascicle RENAME copyright COMPONENT python)
  install(DIRECTORY docs/examples/python/ DESTINATION ${doc_folder}/python3-fascicle/examples COMPONENT python
    PATTERN __pycache__ EXCLUDE)
endif()

# Lists the contents of each package (cmake/sbom.py) from the installed files; of all files if no component is given.
# While packages are made (cmake/packing.cmake), a gap in the list is an error.
set(sbom_components program mesher)
if(TARGET fascicle_library)
  list(APPEND sbom_components library development)
endif()
if(TARGET fascicle_python)
  list(APPEND sbom_components python)
endif()
set(sbom_without)
if(NOT TARGET fascicle-convert)
  list(APPEND sbom_without assimp)
endif()
if(NOT Python3_Interpreter_FOUND)
  find_package(Python3 QUIET COMPONENTS Interpreter)
endif()
if(Python3_Interpreter_FOUND)
  set(sbom ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/cmake/sbom.py
    --version ${PROJECT_VERSION} --source ${CMAKE_SOURCE_DIR})
  foreach(part ${sbom_without})
    list(APPEND sbom --without ${part})
  endforeach()
  string(JOIN "\" \"" sbom ${sbom})
  string(JOIN "," all_components ${sbom_components})
  set(library_package libfascicle${PROJECT_VERSION_MAJOR})
  string(CONFIGURE [[
    set(sbom_program fascicle program)
    set(sbom_library @library_package@ library)
    set(sbom_development libfascicle-dev development)
    set(sbom_mesher fascicle-mesher mesher)
    set(sbom_python python3-fascicle python)
    set(sbom_ fascicle @all_components@)
    set(sbom_built ";@sbom_components@;")
    if(sbom_${CMAKE_INSTALL_COMPONENT} AND
        (NOT CMAKE_INSTALL_COMPONENT OR sbom_built MATCHES ";${CMAKE_INSTALL_COMPONENT};"))
      list(GET sbom_${CMAKE_INSTALL_COMPONENT} 0 sbom_name)
      list(GET sbom_${CMAKE_INSTALL_COMPONENT} 1 sbom_parts)
      set(sbom_file ${CMAKE_INSTALL_PREFIX}/@doc_folder@/${sbom_name}/${sbom_name}.spdx.json)
      set(sbom_strict)
      if(DEFINED ENV{FASCICLE_PACKING})
        set(sbom_strict --strict)
      endif()
      message(STATUS "Installing: $ENV{DESTDIR}${sbom_file}")
      execute_process(COMMAND_ERROR_IS_FATAL ANY COMMAND "@sbom@" --name ${sbom_name} --in ${sbom_parts} ${sbom_strict}
        --root "$ENV{DESTDIR}" --prefix "${CMAKE_INSTALL_PREFIX}" --output "${sbom_file}"
        -- ${CMAKE_INSTALL_MANIFEST_FILES})
      list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${sbom_file})
    endif()
  ]] write_sbom @ONLY)
  install(CODE "${write_sbom}" ALL_COMPONENTS)
else()
  message(WARNING "No lists of what is in the packages: there is no Python to write them")
endif()
include(cmake/packages.cmake)
