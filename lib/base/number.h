/* Numbers as text, with a point whatever the locale of the program: the same options and the same
 * files everywhere. */
#ifndef NSDAE_BASE_NUMBER_H
#define NSDAE_BASE_NUMBER_H

#include <stddef.h>

/* Whether all of text is a number, as strtod reads them. */
int nsdae_number_read(const char *text, double *value);

/* The shortest text that reads back as the same value. */
void nsdae_number_write(double value, char *text, size_t size);

#endif
