/* The name a user may have meant. */
#ifndef NSDAE_BASE_NEAREST_H
#define NSDAE_BASE_NEAREST_H

#include <stddef.h>

typedef struct nsdae_suggest {
  const char *word, *name;
  int distance;
} nsdae_suggest;

nsdae_suggest nsdae_suggest_start(const char *word);
void nsdae_suggest_try(nsdae_suggest *nearest, const char *name);
/* The nearest name tried, or NULL where none is near enough to be offered. */
const char *nsdae_suggest_end(const nsdae_suggest *nearest);

/* Numbers as text, with a point whatever the locale of the program: the same options and the same
 * files everywhere. */

/* Whether all of text is a number, as strtod reads them. */
int nsdae_number_read(const char *text, double *value);

/* The shortest text that reads back as the same value. */
void nsdae_number_write(double value, char *text, size_t size);

#endif
