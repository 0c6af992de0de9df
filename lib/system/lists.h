/* What callbacks of large systems fill: contacts, and rows of Phi_q, in the order in which they
 * come. Where there is no room left an entry is counted and dropped: the list grows between steps,
 * and the step is done again. */
#ifndef NSDAE_SYSTEM_LISTS_H
#define NSDAE_SYSTEM_LISTS_H

#include <nsdae/system.h>

#include "rows.h"
#include "system_impl.h"
#include "thread_pool.h"

/* Not for users: a list has not enough room. It grows between steps, and the step is done again. */
enum { NSDAE_ARRAYS_GROW = -1000 };

/* Room in a list, or what it would have taken: contacts or parts of rows, and their values. */
typedef struct nsdae_room {
  size_t entries, values;
} nsdae_room;

struct nsdae_contact_list {
  const nsdae_blocks *blocks;
  struct nsdae_contact_shares *shares; /* or NULL: one thread */
  nsdae_error *error;
  int nt, status;    /* the first refusal, with its record in error */
  int without_omega; /* it is not read */
  int count;
  nsdae_room room, taken;
  long *id;
  int *block;              /* 2 count */
  double *gap;             /* count */
  nsdae_coefficients *law; /* count */
  double *w;               /* (1 + nt) count: normal, tangents */
  double *omega;           /* (1 + nt) count; zero where not given */
  int *omega_given;        /* count */
  size_t *at;              /* 2 count: part of each block in value, size x (1 + nt) */
  double *value;
};

/* Lists of the threads that fill one together, with as much room. */
typedef struct nsdae_contact_shares {
  nsdae_thread_pool *pool; /* the caller's */
  nsdae_contact_list *part;
  nsdae_error *error; /* one each */
} nsdae_contact_shares;

/* NSDAE_OK or NSDAE_E_MEMORY; of one thread there is nothing to make. */
int nsdae_contact_shares_make(nsdae_contact_shares *shares, nsdae_thread_pool *pool);
void nsdae_contact_shares_release(nsdae_contact_shares *shares);

struct nsdae_row_list {
  const nsdae_system *system; /* for names */
  const nsdae_blocks *blocks;
  nsdae_error *error;
  int kind; /* of its rows: constraints or frictional joints */
  int status;
  int last; /* the row at hand */
  nsdae_room room, taken;
  nsdae_rows *rows; /* to be filled; its count, first and stride are set before */
  const double *x;  /* NULL, or nv: in place of rows product [count] += rows x */
  double *product;
};

/* Empty lists, before the callback. */
void nsdae_contact_list_clear(nsdae_contact_list *list);
void nsdae_row_list_clear(nsdae_row_list *list);
/* After it: all rows have their places. */
void nsdae_row_list_close(nsdae_row_list *list);

/* Whether all that was added is there. */
static inline int nsdae_room_enough(const nsdae_room *room, const nsdae_room *taken)
{
  return taken->entries <= room->entries && taken->values <= room->values;
}

static inline nsdae_room nsdae_room_larger(const nsdae_room *a, const nsdae_room *b)
{
  return (nsdae_room){a->entries > b->entries ? a->entries : b->entries,
                      a->values > b->values ? a->values : b->values};
}

/* Room for at least as much; NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_contact_list_grow(nsdae_contact_list *list, const nsdae_room *room);
int nsdae_row_list_grow(nsdae_row_list *list, const nsdae_room *room);
void nsdae_contact_list_release(nsdae_contact_list *list);
void nsdae_row_list_release(nsdae_row_list *list);

/* W^T v + w of direction d of entry i. */
double nsdae_contact_list_velocity(const nsdae_contact_list *list, int i, int d, const double *v);

/* Appends a copy of entry i of another list, with this gap; there is room. */
void nsdae_contact_list_copy(nsdae_contact_list *list, const nsdae_contact_list *from, int i,
                             double gap);

#endif
