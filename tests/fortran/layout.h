/* Values of the constants, sizes of the structs and places of their fields, by name. */
#ifndef NSDAE_TESTS_LAYOUT_H
#define NSDAE_TESTS_LAYOUT_H

enum { LAYOUT_UNKNOWN = -999999 };

int layout_count(void);

/* Of "NSDAE_OK" (its value), "nsdae_dims" (its size) or "nsdae_dims%nv" (its offset). */
long layout_value(const char *name);

#endif
