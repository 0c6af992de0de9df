/* The name a user may have meant. */
#ifndef NSDAE_BASE_NEAREST_H
#define NSDAE_BASE_NEAREST_H

typedef struct nsdae_suggest {
  const char *word, *name;
  int distance;
} nsdae_suggest;

nsdae_suggest nsdae_suggest_start(const char *word);
void nsdae_suggest_try(nsdae_suggest *nearest, const char *name);
/* The nearest name tried, or NULL where none is near enough to be offered. */
const char *nsdae_suggest_end(const nsdae_suggest *nearest);

#endif
