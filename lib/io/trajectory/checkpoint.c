#include "checkpoint.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const char dataset[] = "/restart/state";

enum { PLACES = 2 };

/* In front of the state in its place. */
typedef struct head {
  char magic[8];
  nsdae_checkpoint_mark mark;
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
  size_t size;
  *checkpoint = (nsdae_checkpoint){.set = -1, .grows = nsdae_sizes_of(sim, 0).varies};
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

void nsdae_checkpoint_create(nsdae_checkpoint *checkpoint, nsdae_h5 *h5)
{
  hsize_t width = checkpoint->width;
  nsdae_h5_layout layout = {
      .rank = 2, .size = {PLACES, width}, .most = {PLACES, width}, .early = 1};
  if (checkpoint->grows) {
    layout.most[1] = H5S_UNLIMITED;
    layout.chunk[0] = 1;
    layout.chunk[1] = 1 << 16;
  }
  checkpoint->set =
      nsdae_h5_dataset(h5, dataset, H5T_NATIVE_UCHAR, &layout, "1",
                       "states for a restart, the last two alternate; read by this library only");
}

/* ---- writing */

/* Places in the file of this width. */
static void set_width(nsdae_checkpoint *c, nsdae_h5 *h5, hsize_t width)
{
  const hsize_t size[2] = {PLACES, width};
  if (nsdae_h5_resize(h5, c->set, size) == NSDAE_OK) c->width = width;
}

void nsdae_checkpoint_write(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                            const nsdae_checkpoint_mark *mark)
{
  nsdae_checkpoint *c = checkpoint;
  size_t size;
  if (h5->status < 0) return;
  int status = nsdae_sim_state_size(sim, &size);
  if (status == NSDAE_OK) status = grow_place(c, sizeof(head) + size);
  if (status == NSDAE_E_MEMORY) nsdae_h5_no_memory(h5);
  unsigned char *state = c->place + sizeof(head);
  if (status == NSDAE_OK) status = nsdae_sim_get_state(sim, state, size);
  if (h5->status == NSDAE_OK) h5->status = status;
  if (status < 0) return;
  head h = {.mark = *mark, .size = (int64_t)size};
  memcpy(h.magic, magic, sizeof magic);
  h.sum = sum_of(&h, state, size);
  memcpy(c->place, &h, sizeof h);
  const hsize_t start[2] = {(hsize_t)((c->newest + 1) % PLACES), 0}, part[2] = {1, sizeof h + size};
  if (part[1] > c->width) set_width(c, h5, part[1] + part[1] / 2);
  if (nsdae_h5_write_part(h5, c->set, H5T_NATIVE_UCHAR, 2, start, part, c->place) < 0) return;
  c->newest = (int)start[0];
  c->used = part[1];
}

void nsdae_checkpoint_trim(nsdae_checkpoint *checkpoint, nsdae_h5 *h5)
{
  if (checkpoint->grows && checkpoint->set >= 0 && checkpoint->used > 0)
    set_width(checkpoint, h5, checkpoint->used);
}

/* ---- reading */

/* What is at the place is whole, and the file has the rows that belong to it. */
static int is_good(const unsigned char *place, hsize_t width, const head *h,
                   const hsize_t rows[NSDAE_TABLES])
{
  if (memcmp(h->magic, magic, sizeof magic) != 0 || h->mark.step < 0) return 0;
  if (h->size < 0 || h->size > (int64_t)(width - sizeof *h)) return 0;
  if (h->sum != sum_of(h, place + sizeof *h, (size_t)h->size)) return 0;
  for (int i = 0; i < NSDAE_TABLES; i++)
    if (h->mark.rows[i] < 0 || (hsize_t)h->mark.rows[i] > rows[i]) return 0;
  return 1;
}

/* Sets sim to the newest good state of the places. */
static void set_newest(nsdae_checkpoint *c, nsdae_h5 *h5, nsdae_sim *sim,
                       const unsigned char *place, const hsize_t *rows, nsdae_checkpoint_mark *mark)
{
  head h, newest = {.mark = {.step = -1}};
  for (int i = 0; i < PLACES; i++) {
    const unsigned char *at = place + (size_t)i * (size_t)c->width;
    memcpy(&h, at, sizeof h);
    if (!is_good(at, c->width, &h, rows) || h.mark.step < newest.mark.step) continue;
    newest = h;
    c->newest = i;
  }
  if (newest.mark.step < 0) {
    nsdae_h5_refuse(h5, "resume",
                    "it has no complete state: the run was killed before its first flush, or the "
                    "file is damaged");
    return;
  }
  *mark = newest.mark;
  place += (size_t)c->newest * (size_t)c->width + sizeof h;
  h5->status = nsdae_sim_set_state(sim, place, (size_t)newest.size);
  if (h5->status < 0 && h5->error) *h5->error = *nsdae_sim_error(sim);
}

void nsdae_checkpoint_take(nsdae_checkpoint *checkpoint, nsdae_h5 *h5, nsdae_sim *sim,
                           const hsize_t rows[NSDAE_TABLES], nsdae_checkpoint_mark *mark)
{
  nsdae_checkpoint *c = checkpoint;
  hsize_t size[2] = {0};
  if (h5->status < 0) return;
  if (nsdae_h5_shape(h5, dataset, 2, size) < 0) {
    h5->status = NSDAE_OK;
    nsdae_h5_refuse(h5, "resume", "it has no state for a restart (/restart/state)");
  }
  if (size[0] != PLACES || (c->grows ? size[1] < sizeof(head) : size[1] != c->width))
    nsdae_h5_refuse(h5, "resume",
                    "its state has another size: another version of the library wrote it");
  c->width = size[1];
  unsigned char *place = nsdae_h5_allocate(h5, PLACES * (size_t)size[1], 1);
  nsdae_h5_read(h5, dataset, H5T_NATIVE_UCHAR, place);
  c->set = nsdae_h5_open_dataset(h5, dataset);
  if (h5->status == NSDAE_OK) set_newest(c, h5, sim, place, rows, mark);
  free(place);
}
