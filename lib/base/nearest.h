/* The name a user may have meant. */
#ifndef NSDAE_BASE_NEAREST_H
#define NSDAE_BASE_NEAREST_H

typedef struct nsdae_nearest {
  const char *word, *name;
  int distance;
} nsdae_nearest;

nsdae_nearest nsdae_nearest_start(const char *word);
void nsdae_nearest_try(nsdae_nearest *nearest, const char *name);
/* The nearest name tried, or NULL where none is near enough to be offered. */
const char *nsdae_nearest_end(const nsdae_nearest *nearest);

#endif
