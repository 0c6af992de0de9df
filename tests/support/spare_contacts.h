/* A system with room for more contacts: its own are at other places, in their order, and those
 * between and behind are open contacts far away, with directions and velocities of zero. */
#ifndef NSDAE_TESTS_SPARE_CONTACTS_H
#define NSDAE_TESTS_SPARE_CONTACTS_H

#include <nsdae/nsdae.h>

enum { SPARE_MOST = 64 };

/* Contact i of k is at place first + (1 + between) i, of first + (1 + between) k in all. */
typedef struct spare_contacts {
  const nsdae_system *of;
  int first, between;
} spare_contacts;

int spare_contacts_place(const spare_contacts *spare, int contact);

/* Whether event differences gaps twice: of one far away that is its rounding over s^2, by which s
 * is chosen. */
int spare_contacts_round(const spare_contacts *spare);

/* The system with spare places; both must outlive it. NULL without memory, or beyond SPARE_MOST. */
nsdae_system *spare_contacts_make(const spare_contacts *spare);

#endif
