/* nsdae: version and export marks. BSD-3-Clause. */
#ifndef NSDAE_VERSION_H
#define NSDAE_VERSION_H

/* The version of these headers; that of the library is nsdae_version(). */
#define NSDAE_VERSION_MAJOR 0
#define NSDAE_VERSION_MINOR 2
#define NSDAE_VERSION_PATCH 0
#define NSDAE_VERSION       "0.2.0"

/* Marks what a shared library exports. */
#if defined(__GNUC__)
#define NSDAE_API __attribute__((visibility("default")))
#else
#define NSDAE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of the library that runs, as "major.minor.patch". */
NSDAE_API const char *nsdae_version(void);

/* How this library was built: compiler, build type, and what is in it, in one line. */
NSDAE_API const char *nsdae_build_info(void);

#ifdef __cplusplus
}
#endif
#endif
