/* The state of a simulation in a trajectory file, and how many rows belong to it. Two places are
 * written in turn, so that one of them is whole at any moment: the newest whose checksum is right
 * and whose rows are in the file is where the run goes on. A state with a contact list has as
 * many bytes as it takes; the places grow with it. */
#ifndef NSDAE_IO_CHECKPOINT_H
#define NSDAE_IO_CHECKPOINT_H

#include <stdint.h>

#include <nsdae/sim.h>

#include "series.h"
#include "hdf5_data.h"

typedef struct nsdae_checkpoint {
  hid_t set;            /* < 0: none */
  int grows;            /* states are of different sizes */
  hsize_t width, used;  /* of a place in the file; of the last state in it */
  int newest;           /* place of the last one written or found */
  unsigned char *place; /* memory of one place */
  size_t room;          /* its bytes */
} nsdae_checkpoint;

/* Rows of the tables and the number of the step at a state, as they are in the file. */
typedef struct nsdae_checkpoint_mark {
  int64_t rows[NSDAE_TABLES];
  int64_t step;
} nsdae_checkpoint_mark;

/* Memory for the states of sim. NSDAE_E_MEMORY. */
int nsdae_checkpoint_init(nsdae_checkpoint *checkpoint, const nsdae_sim *sim);
void nsdae_checkpoint_release(nsdae_checkpoint *checkpoint);

void nsdae_checkpoint_create(nsdae_checkpoint *checkpoint, nsdae_h5 *h5);
/* The state of sim as it is now, in the place of the older one. */
void nsdae_checkpoint_write(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                            const nsdae_checkpoint_mark *mark);

/* Takes from the places what the last two states, which must have the same size, have no use for.
 */
void nsdae_checkpoint_trim(nsdae_checkpoint *checkpoint, nsdae_h5 *h5);

/* Opens those of a file, and sets sim to the newest state that has at most these rows. NSDAE_E_IO:
 * there is none. */
void nsdae_checkpoint_take(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                           const hsize_t rows[NSDAE_TABLES], nsdae_checkpoint_mark *mark);

#endif
