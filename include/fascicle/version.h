/* The version of these headers; fascicle_version() returns that of the library. Before 1.0 a new minor
 * version may change the interface without changing the SONAME, libfascicle.so.0: compile against the minor
 * version that you run with. A new patch version only adds and fixes. */
#ifndef FASCICLE_VERSION_H
#define FASCICLE_VERSION_H

#define FASCICLE_VERSION_MAJOR 0
#define FASCICLE_VERSION_MINOR 1
#define FASCICLE_VERSION_PATCH 0
#define FASCICLE_VERSION_STRING "0.1.0"

#endif /* FASCICLE_VERSION_H */
