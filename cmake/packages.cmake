# Debian packages by CPack: `./do package`. The mesher has its own package, because its binary has another licence.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fascicle)
set(CPACK_PACKAGE_VENDOR "fascicle")
set(CPACK_PACKAGE_CONTACT "The fascicle maintainers <maintainers@fascicle.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${CMAKE_CURRENT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program library development mesher)
if(TARGET fascicle_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME fascicle)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION 
  "From a rigged, animated character it bakes how muscle and fat stretch, lag and jiggle. This is the program.")
# Vulkan is loaded at run time if it is available; bars and tetrahedral meshes need no mesher.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "fascicle-mesher, libvulkan1")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "mesa-vulkan-drivers, blender")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libfascicle${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
# Lets packages that link the library depend on this one.
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "fascicle-mesher, libvulkan1")
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "This is the shared library with the C API.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libfascicle-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libfascicle${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION 
  "Headers for C and C++, CMake and pkg-config files and examples.")

set(CPACK_DEBIAN_MESHER_PACKAGE_NAME fascicle-mesher)
set(CPACK_COMPONENT_MESHER_DESCRIPTION 
  "Fills surfaces with tetrahedra. It is a program of its own, because its binary is under the AGPL-3.0.")

if(TARGET fascicle_python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-fascicle)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # Compiled for one minor version of Python.
  math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
  set(its_python "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "libfascicle${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}), ${its_python}, python3-numpy")
  # dpkg-shlibdeps finds libfascicle here, because no installed package contains it.
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION 
    "This is the Python module: bakes, and solvers as numpy arrays.")
endif()
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_SOURCE_DIR}/cmake/packing.cmake)
include(CPack)
