#include "active_set_island.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dynamic_array.h"
#include "listed.h"

enum { ROUNDS = 60, WIDEST = 24 }; /* of the set; mean width of an envelope */

void nsdae_active_set_layout(nsdae_active_set_island *c, const nsdae_system *system,
                             nsdae_arena *arena)
{
  c->first = NSDAE_ARENA_INTS(arena, system->blocks.count + 2L);
  c->touched = NSDAE_ARENA_INTS(arena, system->blocks.count);
}

/* By contact, of which there is room for one more; the last is by value. */
enum { ARRAYS = 14 };

static void list_arrays(nsdae_active_set_island *c, nsdae_array all[ARRAYS])
{
  const nsdae_array list[ARRAYS] = {
      NSDAE_ARRAY(c->order, 1),  NSDAE_ARRAY(c->position, 1), NSDAE_ARRAY(c->of_block, 2),
      NSDAE_ARRAY(c->part, 2),   NSDAE_ARRAY(c->at, 1),       NSDAE_ARRAY(c->low, 1),
      NSDAE_ARRAY(c->active, 1), NSDAE_ARRAY(c->b, 1),        NSDAE_ARRAY(c->x, 1),
      NSDAE_ARRAY(c->u, 1),      NSDAE_ARRAY(c->rest, 1),     NSDAE_ARRAY(c->A, WIDEST),
      NSDAE_ARRAY(c->L, WIDEST), NSDAE_ARRAY(c->U, 1)};
  memcpy(all, list, sizeof list);
}

int nsdae_active_set_grow(nsdae_active_set_island *c, const nsdae_room *contacts)
{
  nsdae_array all[ARRAYS];
  list_arrays(c, all);
  int status = nsdae_arrays_grow(all, ARRAYS - 1, contacts->entries + 1);
  return status < 0 ? status : nsdae_arrays_grow(all + ARRAYS - 1, 1, contacts->values);
}

void nsdae_active_set_release(nsdae_active_set_island *c)
{
  nsdae_array all[ARRAYS];
  list_arrays(c, all);
  nsdae_arrays_release(all, ARRAYS);
}

/* ---- memory and order */

static const nsdae_rows *normals(const nsdae_island_equations *w)
{
  return &w->terms->by.normal;
}

/* Contacts of the island by block; blocks are counted by their numbers in the island. */
static void by_block(nsdae_active_set_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_members *blocks = &w->islands->block;
  const nsdae_rows *N = normals(w);
  int n = nsdae_members_count(blocks, island);
  for (int i = 0; i < n; i++) c->touched[blocks->of[blocks->first[island] + i]] = i;
  memset(c->first, 0, ((size_t)n + 2) * sizeof *c->first);
  for (int i = 0; i < c->count; i++)
    for (int p = N->first[c->contact[i]]; p < N->first[c->contact[i] + 1]; p++)
      c->first[c->touched[N->block[p]] + 2]++;
  for (int b = 0; b < n; b++) c->first[b + 2] += c->first[b + 1];
  for (int i = 0; i < c->count; i++)
    for (int p = N->first[c->contact[i]]; p < N->first[c->contact[i] + 1]; p++)
      c->of_block[c->first[c->touched[N->block[p]] + 1]++] = i;
}

/* From the contact in c->order[0] on, neighbours behind neighbours. */
static void breadth_first(nsdae_active_set_island *c, const nsdae_rows *N)
{
  for (int i = 0; i < c->count; i++) c->position[i] = -1;
  c->position[c->order[0]] = 0;
  for (int done = 0, found = 1; done < found; done++) {
    int a = c->contact[c->order[done]];
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      int b = c->touched[N->block[p]];
      for (int e = c->first[b]; e < c->first[b + 1]; e++) {
        int other = c->of_block[e];
        if (c->position[other] >= 0) continue;
        c->position[other] = found;
        c->order[found++] = other;
      }
    }
  }
}

/* ---- G and b */

/* U = M^-1 W part by part; b. */
static int gather(nsdae_active_set_island *c, const nsdae_island_equations *w, int island,
                  double *L_block)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_members *members = &w->islands->block;
  const nsdae_rows *N = normals(w);
  size_t at = 0;
  for (int i = 0; i < c->count; i++) {
    int a = c->contact[i];
    c->b[i] = w->terms->w_N[a] + w->law[a].e_n * w->results->before[a];
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      c->part[2 * (size_t)i + (size_t)(p - N->first[a])] = at;
      at += (size_t)nsdae_blocks_size(blocks, N->block[p]);
    }
  }
  for (int m = members->first[island]; m < members->first[island + 1]; m++) {
    int b = members->of[m], n = nsdae_blocks_size(blocks, b);
    nsdae_block_factor factor = {.L = L_block};
    double *v = w->v + blocks->first[b];
    if (nsdae_blocks_factor(blocks, b, w->M, &factor)) return 0;
    memcpy(v, w->r + blocks->first[b], (size_t)n * sizeof *v);
    nsdae_blocks_solve(&factor, v);
    for (int e = c->first[c->touched[b]]; e < c->first[c->touched[b] + 1]; e++) {
      int i = c->of_block[e], p = N->first[c->contact[i]];
      int second = N->block[p] != b;
      const double *W = N->value + N->at[p + second];
      double *U = c->U + c->part[2 * (size_t)i + (size_t)second];
      memcpy(U, W, (size_t)n * sizeof *U);
      nsdae_blocks_solve(&factor, U);
      for (int j = 0; j < n; j++) c->b[i] += W[j] * v[j];
    }
  }
  return 1;
}

/* W_i . U_j over the blocks that both touch. */
static double entry(const nsdae_active_set_island *c, const nsdae_island_equations *w, int i, int j)
{
  const nsdae_rows *N = normals(w);
  int pi = N->first[c->contact[i]], pj = N->first[c->contact[j]];
  double sum = 0;
  for (int p = pi; p < N->first[c->contact[i] + 1]; p++)
    for (int q = pj; q < N->first[c->contact[j] + 1]; q++) {
      if (N->block[p] != N->block[q]) continue;
      const double *W = N->value + N->at[p], *U = c->U + c->part[2 * (size_t)j + (size_t)(q - pj)];
      sum += nsdae_dot(nsdae_blocks_size(&w->system->blocks, N->block[p]), W, U);
    }
  return sum;
}

/* ---- Cholesky factor in an envelope */

/* Where each row's envelope lies; 0 where it is too wide. Row i of A, in the order, has the columns
 * low[i] .. i, the last at at[i]. */
static int lay_out(nsdae_active_set_island *c, const nsdae_island_equations *w)
{
  const nsdae_rows *N = normals(w);
  size_t end = 0;
  for (int i = 0; i < c->count; i++) {
    int a = c->contact[c->order[i]];
    c->low[i] = i;
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      int b = c->touched[N->block[p]];
      for (int e = c->first[b]; e < c->first[b + 1]; e++)
        if (c->position[c->of_block[e]] < c->low[i]) c->low[i] = c->position[c->of_block[e]];
    }
    end += (size_t)(i - c->low[i]) + 1;
    if (end > (size_t)WIDEST * (size_t)c->count) return 0;
    c->at[i] = end - 1;
  }
  return 1;
}

static void assemble(nsdae_active_set_island *c, const nsdae_island_equations *w)
{
  const nsdae_rows *N = normals(w);
  if (c->count > 0) memset(c->A, 0, (c->at[c->count - 1] + 1) * sizeof *c->A);
  for (int i = 0; i < c->count; i++) {
    int a = c->contact[c->order[i]];
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      int b = c->touched[N->block[p]];
      for (int e = c->first[b]; e < c->first[b + 1]; e++) {
        int j = c->position[c->of_block[e]];
        if (j <= i) c->A[c->at[i] - (size_t)(i - j)] = entry(c, w, c->order[i], c->order[j]);
      }
    }
  }
}

/* The envelope of the set, factored row by row into L; rows outside it are those of one. */
static int factor(nsdae_active_set_island *c)
{
  for (int i = 0; i < c->count; i++) {
    double *row = c->L + c->at[i] - (size_t)(i - c->low[i]); /* column low[i] */
    const double *A = c->A + c->at[i] - (size_t)(i - c->low[i]);
    double pivot = c->active[i] ? A[i - c->low[i]] : 1, whole = pivot;
    for (int j = c->low[i]; j < i; j++) {
      int from = c->low[j] > c->low[i] ? c->low[j] : c->low[i];
      const double *other = c->L + c->at[j] - (size_t)(j - from);
      double value = c->active[i] && c->active[j] ? A[j - c->low[i]] : 0;
      value -= nsdae_dot(j - from, row + (from - c->low[i]), other);
      value /= c->L[c->at[j]];
      row[j - c->low[i]] = value;
      pivot -= value * value;
    }
    if (!(pivot > 64 * DBL_EPSILON * whole)) return 0;
    c->L[c->at[i]] = sqrt(pivot);
  }
  return 1;
}

/* y := (L L^T)^-1 y, in the order. */
static void solve(const nsdae_active_set_island *c, double *y)
{
  for (int i = 0; i < c->count; i++) {
    const double *row = c->L + c->at[i] - (size_t)(i - c->low[i]);
    y[i] = (y[i] - nsdae_dot(i - c->low[i], row, y + c->low[i])) / c->L[c->at[i]];
  }
  for (int i = c->count - 1; i >= 0; i--) {
    const double *row = c->L + c->at[i] - (size_t)(i - c->low[i]);
    y[i] /= c->L[c->at[i]];
    for (int j = c->low[i]; j < i; j++) y[j] -= row[j - c->low[i]] * y[i];
  }
}

/* u := W^T (M^-1 W x) + b, in the order: block by block and not by A, so that what presses from
 * both sides of a light block cancels where it is exact, and errors do not add up along a column.
 */
static void velocities(nsdae_active_set_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->block;
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_rows *N = normals(w);
  double *v = w->size; /* of the impulses alone */
  for (int m = members->first[island]; m < members->first[island + 1]; m++) {
    int b = members->of[m];
    memset(v + blocks->first[b], 0, (size_t)nsdae_blocks_size(blocks, b) * sizeof *v);
  }
  for (int i = 0; i < c->count; i++) {
    int k = c->order[i], a = c->contact[k];
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      int b = N->block[p];
      const double *U = c->U + c->part[2 * (size_t)k + (size_t)(p - N->first[a])];
      for (int j = 0; j < nsdae_blocks_size(blocks, b); j++)
        v[blocks->first[b] + j] += U[j] * c->x[i];
    }
  }
  for (int i = 0; i < c->count; i++)
    c->u[i] = c->b[c->order[i]] + nsdae_rows_dot(blocks, N, c->contact[c->order[i]], v);
}

/* x of the set, refined once. */
static int solve_set(nsdae_active_set_island *c, const nsdae_island_equations *w, int island)
{
  if (!factor(c)) return 0;
  memset(c->x, 0, (size_t)c->count * sizeof *c->x);
  for (int round = 0; round < 2; round++) {
    velocities(c, w, island);
    for (int i = 0; i < c->count; i++) c->rest[i] = c->active[i] ? -c->u[i] : 0;
    solve(c, c->rest);
    for (int i = 0; i < c->count; i++) c->x[i] += c->rest[i];
  }
  velocities(c, w, island);
  return 1;
}

/* ---- active-set method */

static int next_set(nsdae_active_set_island *c)
{
  int changed = 0;
  for (int i = 0; i < c->count; i++) {
    int active = c->active[i] ? c->x[i] > 0 : c->u[i] < 0;
    changed += active != c->active[i];
    c->active[i] = active;
  }
  return changed;
}

/* Of x as it is, and of u. */
static double residual(const nsdae_active_set_island *c)
{
  nsdae_natural_residual residual = {0};
  int finite = 1;
  for (int i = 0; i < c->count; i++) {
    nsdae_natural_residual_speed(&residual, c->b[i]);
    nsdae_natural_residual_raise(&residual.left, fabs(fmin(c->x[i] * c->A[c->at[i]], c->u[i])));
    finite = finite && isfinite(c->x[i]) && isfinite(c->u[i]); /* fmin passes over NaN */
  }
  return finite ? nsdae_natural_residual_scaled(&residual) : HUGE_VAL;
}

/* The last set settles, or what it leaves is within rounding. */
static int settle(nsdae_active_set_island *c, const nsdae_island_equations *w, int island,
                  double tol)
{
  double left = HUGE_VAL;
  for (int i = 0; i < c->count; i++) {
    int a = c->contact[c->order[i]];
    c->active[i] = w->results->normal[a] > 0 || (w->fresh[a] && c->b[c->order[i]] < 0);
  }
  for (c->rounds = 0; c->rounds < ROUNDS; c->rounds++) {
    if (!solve_set(c, w, island)) return 0;
    left = residual(c);
    if (!next_set(c) || left <= 64 * DBL_EPSILON) break;
  }
  return left <= tol;
}

/* ---- velocities and residual */

/* v = M^-1 r + U Lambda; what cancels to rounding is zero, as in contacts.c. */
static void scatter(nsdae_active_set_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_members *members = &w->islands->block;
  const nsdae_rows *N = normals(w);
  const double rounding = 32 * DBL_EPSILON;
  for (int m = members->first[island]; m < members->first[island + 1]; m++) {
    int b = members->of[m];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++) w->size[j] = 2 * fabs(w->v[j]);
  }
  for (int i = 0; i < c->count; i++) {
    int k = c->order[i], a = c->contact[k];
    double x = fmax(c->x[i], 0);
    w->results->normal[a] = x;
    w->results->mode[a] = x > 0 ? NSDAE_MODE_SLIP : NSDAE_MODE_OPEN;
    for (int p = N->first[a]; p < N->first[a + 1]; p++) {
      int b = N->block[p], at = blocks->first[b];
      const double *U = c->U + c->part[2 * (size_t)k + (size_t)(p - N->first[a])];
      for (int j = 0; j < nsdae_blocks_size(blocks, b); j++) {
        w->v[at + j] += U[j] * x;
        w->size[at + j] += fabs(U[j] * x);
      }
    }
  }
  for (int m = members->first[island]; m < members->first[island + 1]; m++) {
    int b = members->of[m];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++)
      if (fabs(w->v[j]) <= rounding * w->size[j]) w->v[j] = 0;
  }
}

/* Velocities after, and what they leave of the laws: |min(d Lambda, u)| without friction. */
static void velocities_after(nsdae_active_set_island *c, const nsdae_island_equations *w)
{
  nsdae_impulses *to = w->results;
  int nt = w->system->dims.nt;
  c->residual = (nsdae_natural_residual){0};
  for (int i = 0; i < c->count; i++) {
    int k = c->order[i], a = c->contact[k];
    nsdae_terms_contact_rates(w->terms, a, w->v, to->after, to->after_t);
    for (int j = a * nt; j < (a + 1) * nt; j++) to->tangential[j] = 0;
    double x = to->normal[a] * c->A[c->at[i]], u = to->after[a] + w->law[a].e_n * to->before[a];
    nsdae_natural_residual_speed(&c->residual, c->b[k]);
    nsdae_natural_residual_raise(&c->residual.left, fabs(x < u ? x : u));
  }
}

int nsdae_active_set_fits(const nsdae_island_equations *w, int island)
{
  const nsdae_members *contacts = &w->islands->contact;
  const int *first = normals(w)->first;
  if (nsdae_members_count(&w->islands->row, island) > 0) return 0;
  if (nsdae_members_count(&w->islands->joint, island) > 0) return 0;
  for (int i = contacts->first[island]; i < contacts->first[island + 1]; i++) {
    int a = contacts->of[i];
    if (w->law[a].mu > 0 || first[a + 1] - first[a] > 2 || first[a + 1] == first[a]) return 0;
  }
  return 1;
}

int nsdae_active_set_solve(nsdae_active_set_island *c, const nsdae_island_equations *w, int island,
                           double tol, double *L_block)
{
  const nsdae_members *contacts = &w->islands->contact;
  c->count = nsdae_members_count(contacts, island);
  c->contact = contacts->of + contacts->first[island];
  /* The order of Cuthill and McKee, begun at one end: the last of a search from anywhere. */
  by_block(c, w, island);
  c->order[0] = 0;
  breadth_first(c, normals(w));
  c->order[0] = c->order[c->count - 1];
  breadth_first(c, normals(w));
  if (!lay_out(c, w) || !gather(c, w, island, L_block)) return 0;
  assemble(c, w);
  if (!settle(c, w, island, tol)) return 0;
  scatter(c, w, island);
  velocities_after(c, w);
  return 1;
}
