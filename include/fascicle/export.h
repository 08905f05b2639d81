/* The symbols that the shared library exports. */
#ifndef FASCICLE_EXPORT_H
#define FASCICLE_EXPORT_H

#if defined(FASCICLE_STATIC)
#define FASCICLE_API
#elif defined(_WIN32)
#if defined(FASCICLE_BUILDS_LIBRARY)
#define FASCICLE_API __declspec(dllexport)
#else
#define FASCICLE_API __declspec(dllimport)
#endif
#else
#define FASCICLE_API __attribute__((visibility("default")))
#endif

#endif /* FASCICLE_EXPORT_H */
