# cmake -D PROGRAM=... -P libraries_beside.cmake
#
# Copies the shared libraries that a program needs, except the C library, into the program's folder.
cmake_minimum_required(VERSION 3.25)

get_filename_component(folder ${PROGRAM} DIRECTORY)
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${PROGRAM} RESOLVED_DEPENDENCIES_VAR found
  CONFLICTING_DEPENDENCIES_PREFIX conflict
  PRE_EXCLUDE_REGEXES "^ld-linux" "^libc\\.so" "^libm\\.so")
# When the program is linked again, both the earlier copies and the system's libraries are found.
foreach(name IN LISTS conflict_FILENAMES)
  list(APPEND found ${conflict_${name}})
endforeach()
foreach(library IN LISTS found)
  get_filename_component(name ${library} NAME)
  file(REAL_PATH ${library} file)
  if(NOT file STREQUAL "${folder}/${name}")
    file(COPY_FILE ${file} ${folder}/${name} ONLY_IF_DIFFERENT)
  endif()
endforeach()
