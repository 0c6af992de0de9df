/* A system with fixed contacts as one with a contact list: contact i has the id i, and is listed if
 * its gap is within reach. M, Phi_q, gaps and directions are evaluated as those of the fixed
 * contacts, by differences too, so that both have the same numbers. Contacts have omega if the
 * system has contact_acceleration. */
#ifndef NSDAE_TESTS_AS_LIST_H
#define NSDAE_TESTS_AS_LIST_H

#include <nsdae/nsdae.h>

typedef struct as_list as_list;

/* Blocks of these sizes; count 0: those of the system, or one. A contact touches at most two of
 * them. The system must outlive the copy. NULL without memory. */
as_list *as_list_create(const nsdae_system *system, int count, const int *nq, const int *nv);
/* Releases the copy; NULL is nothing. */
void as_list_destroy(as_list *copy);

/* The system with a list: it is the copy's. */
nsdae_system *as_list_system(const as_list *copy);

/* From now on the list hides contact i, -1: none; 1: it lists every contact whatever the reach. */
void as_list_hide(as_list *copy, int contact);
void as_list_list_all(as_list *copy, int all);
/* Calls of the callback contacts. */
long as_list_calls(const as_list *copy);

#endif
