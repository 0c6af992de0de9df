#include "least.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "errors.h"

/* Entries of dense rows up to which they have room in the arena, 8 MB. Longer rows of a list are
 * copied into memory that grows when they are first used. */
enum { DENSE = 1 << 20 };

/* At a distance from the constraints a dependent row has turned out of the span of the others. A
 * body that is off by the angle a turns its rows by a, two bodies by 2 a; a constraint that is off
 * by phi at the arm r stands for the angle phi / r, and those of a chain of s bodies add up: DRIFT
 * is for 25 pairs. Rounding of the poses makes LEAST. A start that is off by more than MOST / DRIFT
 * is no drift: there is nothing that turns its rows back. */
static const double DRIFT = 50, LEAST = 1e-6, MOST = 1e-2;

double nsdae_least_drift(const nsdae_terms *T, int *worst)
{
  const double *size = T->system->size[NSDAE_NAME_CONSTRAINT];
  double most = 0;
  *worst = -1;
  for (int i = 0; i < T->system->dims.m; i++) {
    double arm = size ? size[i] : 0;
    /* unknown: what the fastest of its coordinates would have to move, of coordinates of size 1 */
    if (!(arm > 0)) arm = nsdae_rows_largest(&T->system->blocks, &T->by.jacobian, i);
    double drift = arm > 0 ? fabs(T->constraint.phi[i]) / arm : 0;
    if (drift > most) most = drift, *worst = i;
  }
  return most;
}

double nsdae_least_turned(double drift)
{
  return DRIFT * drift;
}

double nsdae_least_sine(double rank_tol, double drift)
{
  return fmax(fmax(rank_tol, LEAST), fmin(nsdae_least_turned(drift), MOST));
}

void nsdae_least_layout(nsdae_least *p, const nsdae_system *system, int most, double rank_tol,
                        nsdae_arena *arena)
{
  const nsdae_blocks *blocks = &system->blocks;
  long n = most > 0 ? system->dims.nv : 0;
  p->most = p->kkt.m = most;
  p->kkt.n = (int)n;
  p->kkt.blocks = blocks;
  p->kkt.rank_tol = rank_tol;
  /* not by the room for contacts, which are mostly open */
  p->kkt.typical = 1 + system->dims.m;
  nsdae_kkt_layout(&p->kkt, arena);
  p->grows = !p->given && (system->tracked || (system->call.constraint_rows && most * n > DENSE));
  if (p->grows || p->given) {
    p->J.stride = 1;
    p->J.first = NSDAE_ARENA_INTS(arena, most + 1L);
  }
  if (p->given) {
    p->room = *p->given;
    p->J.block = NSDAE_ARENA_INTS(arena, p->room.entries);
    p->J.at = nsdae_arena_take(arena, (long)p->room.entries, sizeof *p->J.at);
    p->J.value = NSDAE_ARENA_DOUBLES(arena, p->room.values);
  } else if (!p->grows) {
    nsdae_terms_layout_rows(&p->J, blocks, most, n, 1, arena);
    p->room = (nsdae_room){(size_t)most * (size_t)blocks->count, (size_t)(most * n)};
  }
  p->c = NSDAE_ARENA_DOUBLES(arena, most);
  p->change = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
}

void nsdae_least_release(nsdae_least *p)
{
  const nsdae_array all[] = {NSDAE_ARRAY(p->J.block, 1), NSDAE_ARRAY(p->J.at, 1),
                             NSDAE_ARRAY(p->J.value, 1)};
  if (p->grows) nsdae_arrays_release(all, 3);
  nsdae_kkt_release(&p->kkt);
}

void nsdae_least_start(nsdae_least *p)
{
  p->rows = 0;
  p->status = NSDAE_OK;
  memset(p->change, 0, (size_t)p->kkt.blocks->first[p->kkt.blocks->count] * sizeof *p->change);
}

/* Room for these parts and values; if there is less, for twice as many. */
static int reserve(nsdae_least *p, const nsdae_room *taken)
{
  if (nsdae_room_enough(&p->room, taken)) return NSDAE_OK;
  const nsdae_array parts[] = {NSDAE_ARRAY(p->J.block, 1), NSDAE_ARRAY(p->J.at, 1)};
  const nsdae_array values[] = {NSDAE_ARRAY(p->J.value, 1)};
  int status = nsdae_arrays_grow(parts, 2, 2 * taken->entries);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(values, 1, 2 * taken->values);
  if (status == NSDAE_OK) p->room = (nsdae_room){2 * taken->entries, 2 * taken->values};
  return status;
}

void nsdae_least_append(nsdae_least *p, const nsdae_rows *rows, int i, double missing)
{
  const nsdae_blocks *blocks = p->kkt.blocks;
  nsdae_rows *J = &p->J;
  int part = J->first[p->rows];
  size_t at = 0;
  if (part > 0) at = J->at[part - 1] + (size_t)nsdae_blocks_size(blocks, J->block[part - 1]);
  for (int from = rows->first[i]; from < rows->first[i + 1] && p->status == NSDAE_OK; from++) {
    size_t size = (size_t)nsdae_blocks_size(blocks, rows->block[from]);
    const double *value = rows->value + rows->at[from];
    const nsdae_room taken = {(size_t)part + 1, at + size};
    p->status = reserve(p, &taken);
    if (p->status < 0) continue;
    J->block[part] = rows->block[from];
    J->at[part++] = at;
    for (size_t j = 0; j < size; j++) J->value[at++] = value[j * rows->stride];
  }
  p->c[p->rows++] = -missing;
  J->first[p->rows] = part;
}

int nsdae_least_reserve(nsdae_least *p, const nsdae_terms *T, enum nsdae_least_rows rows)
{
  const nsdae_by_blocks *by = &T->by;
  const nsdae_dims *d = &T->system->dims;
  int all = rows == NSDAE_LEAST_ALL, nt = all ? d->nt : 0;
  unsigned terms = NSDAE_TERM_JACOBIAN;
  if (rows != NSDAE_LEAST_CONSTRAINTS) terms |= NSDAE_TERM_NORMAL;
  if (all) terms |= NSDAE_TERM_TANGENT | NSDAE_TERM_SLIDE;
  if (p->most == 0 || !(p->kkt.is_sparse || p->grows) || (terms & ~T->have)) return NSDAE_OK;
  /* Independent rows are nv at most. Of many more, as of the contacts of all pairs of bodies, few
   * are closed together, and the Schur complement of all would be dense. */
  int contacts = rows != NSDAE_LEAST_CONSTRAINTS ? by->normal.count : 0;
  if (d->m + contacts * (1 + nt) > 2 * d->nv) return NSDAE_OK;
  nsdae_least_start(p);
  for (int i = 0; i < d->m; i++) nsdae_least_append(p, &by->jacobian, i, 0);
  for (int i = 0; i < contacts; i++) {
    nsdae_least_append(p, &by->normal, i, 0);
    for (int j = i * nt; j < (i + 1) * nt; j++) nsdae_least_append(p, &by->tangent, j, 0);
  }
  for (int j = 0; all && j < d->f; j++) nsdae_least_append(p, &by->frictional_joint, j, 0);
  p->kkt.m = p->J.count = p->rows;
  int status = p->status == NSDAE_OK ? nsdae_kkt_reserve(&p->kkt, &p->J) : p->status;
  return status < 0 ? nsdae_error_memory(T->error, "nsdae_sim_init") : NSDAE_OK;
}

int nsdae_least_solve(nsdae_least *p, const nsdae_terms *T)
{
  if (p->status < 0) return nsdae_error_memory(T->error, "nsdae_sim");
  p->kkt.m = p->J.count = p->rows;
  int status = nsdae_kkt_factor(&p->kkt, T->M, &p->J);
  if (status == NSDAE_E_MASS) {
    const char *callback = nsdae_system_mass_name(T->system);
    nsdae_error_set(T->error, status, "nsdae_sim", callback,
                    "the mass matrix is not positive definite at t = %g, in a projection: pivot "
                    "%d of %d is not above rounding; check the callback %s",
                    nsdae_terms_time(T), p->kkt.pivot, p->kkt.n, callback);
    nsdae_system_name_item(T->system, NSDAE_NAME_VELOCITY, p->kkt.pivot - 1, T->error);
    return status;
  }
  if (status < 0) return nsdae_terms_unsolved(T, &p->kkt, status);
  p->kkt.sparse.rank.chosen = 1; /* equations of redundant rows differ by what is projected */
  return nsdae_terms_solve(T, &p->kkt, 1, p->change, p->c);
}
