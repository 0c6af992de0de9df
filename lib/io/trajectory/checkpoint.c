#include "checkpoint.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "hdf5_read.h"
#include "dataset_table.h"

static const char dataset[] = "/restart/state";

enum { PLACES = 2 };

/* In front of the state in its place. */
typedef struct head {
  char magic[8];
  int64_t rows[NSDAE_CHECKPOINT_TABLES];
  int64_t step;
  int64_t size; /* of the state */
  uint64_t sum; /* of all but itself */
} head;

static const char magic[8] = "nsdae-st";

/* ---- memory and checksum */

/* FNV-1a, 64 bits (Fowler, Noll, Vo; RFC 9923). */
static uint64_t add_up(uint64_t sum, const void *bytes, size_t size)
{
  const unsigned char *b = bytes;
  for (size_t i = 0; i < size; i++) sum = (sum ^ b[i]) * UINT64_C(1099511628211);
  return sum;
}

static uint64_t sum_of(const head *h, const unsigned char *state, size_t size)
{
  uint64_t sum = add_up(UINT64_C(14695981039346656037), h, offsetof(head, sum));
  return add_up(sum, state, size);
}

/* Memory for a place of this number of bytes; half as much again where it must grow, so that it
 * seldom does. */
static int grow_place(nsdae_checkpoint *c, size_t bytes)
{
  if (bytes <= c->room) return NSDAE_OK;
  size_t room = c->room > 0 ? bytes + bytes / 2 : bytes;
  unsigned char *place = realloc(c->place, room);
  if (!place) return NSDAE_E_MEMORY;
  memset(place + c->room, 0, room - c->room);
  c->place = place;
  c->room = room;
  return NSDAE_OK;
}

int nsdae_checkpoint_init(nsdae_checkpoint *checkpoint, const nsdae_sim *sim)
{
  nsdae_sizes sizes;
  size_t size;
  nsdae_sizes_of(&sizes, sim);
  *checkpoint = (nsdae_checkpoint){.set = -1, .grows = sizes.listed};
  int status = nsdae_sim_state_size(sim, &size);
  if (status < 0) return status;
  checkpoint->width = sizeof(head) + size;
  return grow_place(checkpoint, sizeof(head) + size);
}

void nsdae_checkpoint_release(nsdae_checkpoint *checkpoint)
{
  free(checkpoint->place);
  *checkpoint = (nsdae_checkpoint){.set = -1};
}

int nsdae_checkpoint_create(nsdae_checkpoint *checkpoint, nsdae_h5 *h5)
{
  const hsize_t size[2] = {PLACES, checkpoint->width};
  return nsdae_h5_bytes(h5, dataset, size, checkpoint->grows,
                        "states for a restart, the last two alternate; read by this library only",
                        &checkpoint->set);
}

/* ---- writing */

static unsigned char *state_of(const nsdae_checkpoint *c)
{
  return c->place + sizeof(head);
}

/* The state as it is now, behind the room for the head. */
static int read_state(nsdae_checkpoint *c, nsdae_h5 *h5, nsdae_sim *sim, size_t *size)
{
  int status = nsdae_sim_state_size(sim, size);
  if (status == NSDAE_OK) status = grow_place(c, sizeof(head) + *size);
  if (status == NSDAE_E_MEMORY)
    return nsdae_error_set(h5->error, status, "nsdae_trajectory", "", "out of memory");
  return status < 0 ? status : nsdae_sim_get_state(sim, state_of(c), *size);
}

/* The places of the file, where a state is too long for them. */
static int widen(nsdae_checkpoint *c, nsdae_h5 *h5, hsize_t bytes)
{
  const hsize_t size[2] = {PLACES, bytes + bytes / 2};
  if (bytes <= c->width) return NSDAE_OK;
  int status = nsdae_h5_resize(h5, c->set, size);
  if (status == NSDAE_OK) c->width = size[1];
  return status;
}

int nsdae_checkpoint_write(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                           const nsdae_checkpoint_mark *mark)
{
  size_t size;
  head h = {.step = mark->step};
  int next = (checkpoint->newest + 1) % PLACES;
  int status = read_state(checkpoint, h5, sim, &size);
  if (status < 0) return status;
  memcpy(h.magic, magic, sizeof magic);
  h.size = (int64_t)size;
  for (int i = 0; i < NSDAE_CHECKPOINT_TABLES; i++) h.rows[i] = (int64_t)mark->rows[i];
  h.sum = sum_of(&h, state_of(checkpoint), size);
  memcpy(checkpoint->place, &h, sizeof h);
  status = widen(checkpoint, h5, sizeof h + size);
  if (status == NSDAE_OK)
    status =
        nsdae_h5_write_row(h5, checkpoint->set, (hsize_t)next, sizeof h + size, checkpoint->place);
  if (status < 0) return status;
  checkpoint->newest = next;
  checkpoint->used = sizeof h + size;
  return NSDAE_OK;
}

int nsdae_checkpoint_trim(nsdae_checkpoint *checkpoint, nsdae_h5 *h5)
{
  const hsize_t size[2] = {PLACES, checkpoint->used};
  if (!checkpoint->grows || checkpoint->set < 0 || checkpoint->used == 0) return NSDAE_OK;
  checkpoint->width = checkpoint->used;
  return nsdae_h5_resize(h5, checkpoint->set, size);
}

/* ---- reading */

static int unusable(nsdae_h5 *h5, const char *why)
{
  return nsdae_error_set(h5->error, NSDAE_E_IO, "nsdae_trajectory_resume", "path",
                         "cannot resume '%.90s': %s", h5->path, why);
}

int nsdae_checkpoint_open(nsdae_checkpoint *checkpoint, nsdae_h5 *h5)
{
  hsize_t size[2];
  int status = nsdae_h5_shape(h5, dataset, 2, size);
  if (status < 0) return unusable(h5, "it has no state for a restart (/restart/state)");
  int wide = checkpoint->grows ? size[1] >= sizeof(head) : size[1] == checkpoint->width;
  if (size[0] != PLACES || !wide)
    return unusable(h5, "its state has another size: another version of the library wrote it");
  if (grow_place(checkpoint, size[1]) < 0)
    return nsdae_error_memory(h5->error, "nsdae_trajectory_resume");
  checkpoint->width = size[1];
  return nsdae_h5_open_series(h5, dataset, &checkpoint->set);
}

/* What is at the place is whole, and the file has the rows that belong to it. */
static int is_good(const nsdae_checkpoint *c, const hsize_t rows[NSDAE_CHECKPOINT_TABLES])
{
  head h;
  memcpy(&h, c->place, sizeof h);
  if (memcmp(h.magic, magic, sizeof magic) != 0) return 0;
  if (h.size < 0 || h.size > (int64_t)(c->width - sizeof h)) return 0;
  if (h.sum != sum_of(&h, state_of(c), (size_t)h.size)) return 0;
  for (int i = 0; i < NSDAE_CHECKPOINT_TABLES; i++)
    if (h.rows[i] < 0 || (hsize_t)h.rows[i] > rows[i]) return 0;
  return 1;
}

/* Reads a place; the step of its state, or -1 where there is nothing good in it. */
static int read_place(nsdae_checkpoint *c, nsdae_h5 *h5, int place, const hsize_t *rows,
                      int64_t *step)
{
  head h;
  *step = -1;
  int status = nsdae_h5_read_row(h5, c->set, (hsize_t)place, c->width, c->place);
  if (status < 0 || !is_good(c, rows)) return status;
  memcpy(&h, c->place, sizeof h);
  *step = h.step;
  return NSDAE_OK;
}

int nsdae_checkpoint_take(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                          const hsize_t rows[NSDAE_CHECKPOINT_TABLES], nsdae_checkpoint_mark *mark)
{
  head h;
  int64_t step[PLACES];
  int status = read_place(checkpoint, h5, 0, rows, &step[0]);
  if (status == NSDAE_OK) status = read_place(checkpoint, h5, 1, rows, &step[1]);
  if (status < 0) return status;
  if (step[0] < 0 && step[1] < 0)
    return unusable(h5, "it has no complete state: the run was killed before its first flush, or "
                        "the file is damaged");
  checkpoint->newest = step[1] < step[0] ? 0 : 1;
  status = read_place(checkpoint, h5, checkpoint->newest, rows, &step[0]);
  if (status < 0) return status;
  memcpy(&h, checkpoint->place, sizeof h);
  mark->step = (long)h.step;
  for (int i = 0; i < NSDAE_CHECKPOINT_TABLES; i++) mark->rows[i] = (hsize_t)h.rows[i];
  status = nsdae_sim_set_state(sim, state_of(checkpoint), (size_t)h.size);
  if (status < 0 && h5->error) *h5->error = *nsdae_sim_error(sim);
  return status;
}

void nsdae_checkpoint_close(nsdae_checkpoint *checkpoint)
{
  if (checkpoint->set >= 0) H5Dclose(checkpoint->set);
  checkpoint->set = -1;
}
