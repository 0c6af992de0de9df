/* The terms that callbacks give by blocks or by list: M, rows of Phi_q and W_S^T, contacts.
 *
 * A list at a point is what the callback says within its reach. The contacts that a step closes are
 * selected from it: contact a of the step has row a of normal, gap[a] and w_N[a], and its tangents
 * the rows a nt .. of tangent, at every point that the step evaluates. Of a model whose contacts
 * are tracked (tracked.h) contact a is the one in slot a. */
#ifndef NSDAE_TERMS_LISTED_H
#define NSDAE_TERMS_LISTED_H

#include <limits.h>

#include "terms.h"

/* Brings the list up to date, with every contact of a gap up to reach. NSDAE_OK, NSDAE_ARRAYS_GROW,
 * what the callback failed with or was refused with. */
int nsdae_terms_contacts(nsdae_terms *terms, double reach);

/* Contact a of the step is entry item[a] of the list, -1: it is far away, without directions; item
 * NULL: it is entry a. */
void nsdae_terms_select(nsdae_terms *terms, int count, const int *item);

/* Every contact of a list. */
void nsdae_terms_select_all(nsdae_terms *terms);

/* Gaps, directions, velocities at v = 0 of the slots, from the list within the table's reach; with
 * the statuses of nsdae_terms_contacts. */
int nsdae_terms_slots(nsdae_terms *terms);
/* The same of accelerations at v' = 0: given, or by differences of the velocities by id. */
int nsdae_terms_slot_accelerations(nsdae_terms *terms);
/* What is in the slots, or the reach, changed: their terms are out of date. */
void nsdae_terms_forget_slots(nsdae_terms *terms);
/* NSDAE_OK, or NSDAE_E_CALLBACK with the record: entry i of the list has other blocks than the
 * contact of the same id in the slot. */
int nsdae_terms_same_blocks(const nsdae_terms *terms, int i, int slot);
/* NSDAE_E_ARGUMENT with the record: the list has this id twice. */
int nsdae_terms_id_twice(const nsdae_terms *terms, long id);
/* What item i of a kind is called; a contact of a list, which is its entry, by its id. */
const char *nsdae_terms_called(const nsdae_terms *terms, int kind, int i,
                               char text[NSDAE_CALLED_SIZE]);

/* The contacts that there can be at a point, k; of a list any number. The blocks that a contact
 * touches, at most. How many of its directions, from the normal on, touch all of these. */
enum { NSDAE_ANY_NUMBER = INT_MAX };
static inline int nsdae_terms_most(const nsdae_system *s)
{
  return s->by_list ? NSDAE_ANY_NUMBER : s->dims.k;
}
static inline int nsdae_terms_parts(const nsdae_system *s)
{
  return s->by_list ? 2 : s->blocks.count;
}
static inline int nsdae_terms_differing(const nsdae_system *s)
{
  return s->by_list ? 1 : 1 + s->dims.nt;
}
/* Room for the contacts: of a list this. */
nsdae_room nsdae_terms_room(const nsdae_system *system, const nsdae_room *list);
/* The source of closed contacts: the list with every contact of a gap up to reach, or NULL, where
 * contacts have numbers and gaps of their own. The statuses of nsdae_terms_contacts. */
int nsdae_terms_find(nsdae_terms *terms, double reach, const nsdae_contact_list **list);

/* The callbacks of terms.c. */
int nsdae_terms_mass_blocks(nsdae_terms *terms);
/* of Phi_q; of frictional joints, with their w */
int nsdae_terms_rows(nsdae_terms *terms, nsdae_row_list *list);

/* Room for lists of contacts and of rows, of Phi_q and of frictional joints; NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_terms_grow(nsdae_terms *terms, const nsdae_room *contacts, const nsdae_room *rows);
void nsdae_terms_release(nsdae_terms *terms);

#endif
