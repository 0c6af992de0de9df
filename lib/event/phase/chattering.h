/* Contacts that rattle: whose instants follow each other, each soon after the one before. Past 2000
 * of them the tolerance of such a contact doubles with every 64th, so that it comes to an
 * end; one that is late begins anew. */
#ifndef NSDAE_EVENT_CHATTERING_H
#define NSDAE_EVENT_CHATTERING_H

typedef struct nsdae_chattering {
  int *count;   /* k */
  double *last; /* k: time of the last */
} nsdae_chattering;

/* An instant of the contact at t, which counts several times where it is sooner than that after the
 * last. */
void nsdae_chattering_note(const nsdae_chattering *rattle, int contact, double t, double soon,
                           int many);

/* 1, or more: the factor on the tolerances. */
double nsdae_chattering_blur(const nsdae_chattering *rattle, int contact);

/* Past few it doubles with every `each`, twenty times at most. */
double nsdae_chattering_growth(int count, int few, double each);

#endif
