/* nsdae: version and export marks. BSD-3-Clause. */
#ifndef NSDAE_VERSION_H
#define NSDAE_VERSION_H

/* Version of these headers; nsdae_version() is that of the library. */
#define NSDAE_VERSION_MAJOR 0
#define NSDAE_VERSION_MINOR 3
#define NSDAE_VERSION_PATCH 0
#define NSDAE_VERSION       "0.3.0"

/* Symbols that a shared library exports. */
#if defined(__GNUC__)
#define NSDAE_API __attribute__((visibility("default")))
#else
#define NSDAE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the loaded library, "major.minor.patch". */
NSDAE_API const char *nsdae_version(void);

/* Compiler, build type and optional features of the loaded library, in one line. */
NSDAE_API const char *nsdae_build_info(void);

#ifdef __cplusplus
}
#endif
#endif
