#include "static_condensation.h"

#include <math.h>
#include <string.h>

#include "vector.h"

/* A row with a smaller squared sine to those before it is dependent on them, see sparse_kkt.h. */
static const double DEPENDENT = 1e-12;

/* Numbers of R, T and W for each number of J, up to which sweeps over W cost less than those over
 * J, of which a chain of n joints needs some n^2. */
enum { NUMBERS = 8 };

/* Pairs of contacts that are looked at, for each value of H: as many as the sweeps of a solution
 * that read it. */
enum { PAIRS = 20 };

static inline int most(int a, int b)
{
  return a > b ? a : b;
}

/* ---- memory: what follows from the pattern of J_b first, then what the envelope takes */

static void lay_out_pattern(void *object, nsdae_arena *arena)
{
  nsdae_fc_condensed *c = object;
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  long columns = v->row[p->contacts], joints = v->entries - p->first[p->contacts];
  c->S.start = NSDAE_ARENA_INTS(arena, p->blocks + 2L);
  c->S.touching = NSDAE_ARENA_INTS(arena, joints);
  c->S.first = NSDAE_ARENA_INTS(arena, c->rows);
  c->S.end = NSDAE_ARENA_INTS(arena, c->rows);
  c->S.at = nsdae_arena_take(arena, c->rows + 1L, sizeof *c->S.at);
  c->column = NSDAE_ARENA_INTS(arena, columns + 1);
  c->part = nsdae_arena_take(arena, 3L * p->first[p->contacts], sizeof *c->part);
  c->g = NSDAE_ARENA_DOUBLES(arena, c->rows);
  c->q = NSDAE_ARENA_DOUBLES(arena, columns);
  c->base = NSDAE_ARENA_DOUBLES(arena, columns + c->rows);
  c->entry = NSDAE_ARENA_INTS(arena, p->contacts + 1L);
  c->item = nsdae_arena_take(arena, p->contacts, sizeof *c->item);
}

static void lay_out_values(void *object, nsdae_arena *arena)
{
  nsdae_fc_condensed *c = object;
  long contacts = c->global->view.p->contacts;
  c->S.R = NSDAE_ARENA_DOUBLES(arena, c->sizes[0]);
  c->T = NSDAE_ARENA_DOUBLES(arena, c->sizes[1]);
  c->W = NSDAE_ARENA_DOUBLES(arena, c->sizes[2]);
  c->block = NSDAE_ARENA_INTS(arena, contacts * contacts);
}

void nsdae_fc_condensed_release(nsdae_fc_condensed *c)
{
  for (int i = 0; i < 2; i++) nsdae_arena_release(&c->memory[i]);
}

/* ---- the envelope of S */

/* Entries of J_b by block, in the order of their rows (counting sort). */
static void list_touching(nsdae_fc_condensed *c)
{
  const nsdae_friction_problem *p = c->global->view.p;
  int from = p->first[p->contacts], to = c->global->view.entries;
  memset(c->S.start, 0, ((size_t)p->blocks + 2) * sizeof *c->S.start);
  for (int e = from; e < to; e++) c->S.start[p->block[e] + 2]++;
  for (int b = 0; b < p->blocks; b++) c->S.start[b + 2] += c->S.start[b + 1];
  for (int i = 0; i < c->rows; i++)
    for (int e = p->first[p->contacts + i]; e < p->first[p->contacts + i + 1]; e++)
      c->S.touching[c->S.start[p->block[e] + 1]++] = i;
}

static void find_envelope(nsdae_fc_condensed *c)
{
  const nsdae_friction_problem *p = c->global->view.p;
  list_touching(c);
  c->S.at[0] = 0;
  for (int i = 0; i < c->rows; i++) {
    c->S.first[i] = i;
    for (int e = p->first[p->contacts + i]; e < p->first[p->contacts + i + 1]; e++)
      c->S.first[i] = nsdae_fewer(c->S.first[i], c->S.touching[c->S.start[p->block[e]]]);
    c->S.at[i + 1] = c->S.at[i] + (size_t)(i + 1 - c->S.first[i]);
  }
  for (int i = c->rows - 1, low = c->rows, end = c->rows; i >= 0; i--) {
    c->S.end[i] = end;
    low = nsdae_fewer(low, c->S.first[i]);
    if (low == i) end = i;
  }
  c->sizes[0] = c->S.at[c->rows];
}

/* The columns of J_c, and what T takes. */
static void list_parts(nsdae_fc_condensed *c)
{
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  c->parts = 0;
  c->sizes[1] = 0;
  for (int i = 0, column = 0; i < p->contacts; i++)
    for (int d = 0; d < nsdae_fc_rows(p, i); d++) {
      c->column[column++] = c->parts;
      for (int e = p->first[i]; e < p->first[i + 1]; e++) {
        int b = p->block[e], joined = c->S.start[b + 1] > c->S.start[b];
        int low = joined ? c->S.touching[c->S.start[b]] : 0, high = joined ? c->S.end[low] : 0;
        const double *J = c->global->J + v->at[e] + (size_t)d * (size_t)p->size[b];
        c->part[c->parts++] = (nsdae_fc_condensed_part){b, low, high, J, c->sizes[1]};
        c->sizes[1] += (size_t)(high - low);
      }
    }
  c->column[v->row[p->contacts]] = c->parts;
}

/* Whether W has an entry for the contacts i and j. */
static int coupled(const nsdae_fc_condensed *c, int i, int j)
{
  const int *row = c->global->view.row;
  for (int e = c->column[row[i]]; e < c->column[row[i] + 1]; e++)
    for (int f = c->column[row[j]]; f < c->column[row[j] + 1]; f++) {
      const nsdae_fc_condensed_part *a = &c->part[e], *b = &c->part[f];
      if (a->block == b->block || most(a->low, b->low) < nsdae_fewer(a->high, b->high)) return 1;
    }
  return 0;
}

static void count_couplings(nsdae_fc_condensed *c)
{
  const nsdae_friction_problem *p = c->global->view.p;
  c->sizes[2] = 0;
  for (int i = 0; i < p->contacts; i++)
    for (int j = 0; j < p->contacts; j++)
      if (coupled(c, i, j)) c->sizes[2] += (size_t)(nsdae_fc_rows(p, i) * nsdae_fc_rows(p, j));
}

/* ---- numbers */

/* R, in its rows; 0: the rows are dependent. */
static int factor(nsdae_fc_condensed *c)
{
  for (int i = 0; i < c->rows; i++) {
    double *Ri = c->S.R + c->S.at[i] - c->S.first[i], own = Ri[i];
    for (int j = c->S.first[i]; j < i; j++) {
      const double *Rj = c->S.R + c->S.at[j] - c->S.first[j];
      int from = most(c->S.first[i], c->S.first[j]);
      if (from < j) Ri[j] -= nsdae_dot(j - from, Ri + from, Rj + from);
      Ri[j] /= Rj[j];
    }
    int below = i - c->S.first[i];
    double pivot = own - nsdae_dot(below, Ri + c->S.first[i], Ri + c->S.first[i]);
    if (!(pivot > DEPENDENT * own)) return 0;
    Ri[i] = sqrt(pivot);
  }
  return 1;
}

/* S in the place of R. */
static void form(nsdae_fc_condensed *c)
{
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  memset(c->S.R, 0, c->sizes[0] * sizeof *c->S.R);
  for (int i = 0; i < c->rows; i++) {
    double *R = c->S.R + c->S.at[i] - c->S.first[i];
    if (p->compliance) R[i] = p->compliance[v->row[p->contacts + i]];
    for (int e = p->first[p->contacts + i]; e < p->first[p->contacts + i + 1]; e++) {
      int b = p->block[e], n = p->size[b];
      for (int t = c->S.start[b]; t < c->S.start[b + 1] && c->S.touching[t] <= i; t++) {
        int j = c->S.touching[t], f = p->first[p->contacts + j];
        while (p->block[f] != b) f++;
        R[j] += nsdae_dot(n, c->global->J + v->at[e], c->global->J + v->at[f]);
      }
    }
  }
}

/* x := R^-1 x of the rows low .. high - 1; those before are zero. */
static void solve_lower(const nsdae_fc_condensed *c, int low, int high, double *x)
{
  for (int i = low; i < high; i++) {
    const double *R = c->S.R + c->S.at[i] - c->S.first[i];
    int from = most(low, c->S.first[i]);
    x[i - low] = (x[i - low] - nsdae_dot(i - from, R + from, x + from - low)) / R[i];
  }
}

/* g := R^-1 u_b and q := u_c - T^T g. */
static void condense_velocities(nsdae_fc_condensed *c, const double *u)
{
  int columns = c->global->view.row[c->global->view.p->contacts];
  memcpy(c->g, u + columns, (size_t)c->rows * sizeof *c->g);
  solve_lower(c, 0, c->rows, c->g);
  for (int k = 0; k < columns; k++) {
    c->q[k] = u[k];
    for (const nsdae_fc_condensed_part *a = c->part + c->column[k]; a < c->part + c->column[k + 1];
         a++)
      c->q[k] -= nsdae_dot(a->high - a->low, c->T + a->at, c->g + a->low);
  }
}

static void condense_columns(nsdae_fc_condensed *c)
{
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  memset(c->T, 0, c->sizes[1] * sizeof *c->T);
  for (int k = 0; k < v->row[p->contacts]; k++)
    for (int e = c->column[k]; e < c->column[k + 1]; e++) {
      const nsdae_fc_condensed_part *a = &c->part[e];
      double *T = c->T + a->at;
      if (a->low == a->high) continue;
      for (int t = c->S.start[a->block]; t < c->S.start[a->block + 1]; t++) {
        int i = c->S.touching[t], f = p->first[p->contacts + i];
        while (p->block[f] != a->block) f++;
        T[i - a->low] = nsdae_dot(p->size[a->block], a->J, c->global->J + v->at[f]);
      }
      solve_lower(c, a->low, a->high, T);
    }
}

/* W_kl of two columns. */
static double response(const nsdae_fc_condensed *c, int k, int l)
{
  double sum = 0;
  for (int e = c->column[k]; e < c->column[k + 1]; e++)
    for (int f = c->column[l]; f < c->column[l + 1]; f++) {
      const nsdae_fc_condensed_part *a = &c->part[e], *b = &c->part[f];
      int low = most(a->low, b->low), high = nsdae_fewer(a->high, b->high);
      if (a->block == b->block) sum += nsdae_dot(c->global->view.p->size[a->block], a->J, b->J);
      if (low < high)
        sum -= nsdae_dot(high - low, c->T + a->at + (low - a->low), c->T + b->at + (low - b->low));
    }
  return sum;
}

/* W_ij, if i < j, in item i. */
static const double *find(const nsdae_fc_condensed *c, int i, int j)
{
  const nsdae_friction_problem *p = c->global->view.p;
  const double *W = c->W + c->item[i];
  for (const int *block = c->block + c->entry[i]; *block != j; block++)
    W += nsdae_fc_rows(p, i) * nsdae_fc_rows(p, *block);
  return W;
}

/* Item i has the columns W_ji; those with j < i are the rows of item j. Returns 0 if the joints
 * hold a contact: to rounding it cannot move. */
static int condense_couplings(nsdae_fc_condensed *c)
{
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  double *W = c->W;
  int entries = 0;
  for (int i = 0; i < p->contacts; i++) {
    int columns = nsdae_fc_rows(p, i);
    double own = 0;
    c->entry[i] = entries;
    c->item[i] = (size_t)(W - c->W);
    for (int j = 0; j < p->contacts; j++) {
      int rows = nsdae_fc_rows(p, j);
      if (!coupled(c, i, j)) continue;
      c->block[entries++] = j;
      const double *other = j < i ? find(c, j, i) : NULL;
      for (int k = 0; k < columns; k++)
        for (int l = 0; l < rows; l++, W++) {
          *W = other             ? other[l * columns + k]
               : i == j && l < k ? W[(l - k) * rows + k - l]
                                 : response(c, v->row[i] + k, v->row[j] + l);
          if (i == j && k == l) own += *W;
        }
    }
    if (!(own / columns > DEPENDENT * c->global->d[i])) return 0;
  }
  c->entry[p->contacts] = entries;
  return 1;
}

int nsdae_fc_condense(nsdae_fc_condensed *c, const nsdae_fc_global *global)
{
  const nsdae_fc_view *v = &global->view;
  const nsdae_friction_problem *p = v->p;
  c->global = global;
  c->rows = p->bilateral;
  if (p->form != NSDAE_FRICTION_GLOBAL || c->rows == 0 || p->contacts == 0 || p->blocks < 2)
    return 0;
  if ((size_t)p->contacts * (size_t)p->contacts > PAIRS * v->values) return 0;
  if (nsdae_arena_fit(&c->memory[0], lay_out_pattern, c) < 0) return NSDAE_E_MEMORY;
  find_envelope(c);
  list_parts(c);
  count_couplings(c);
  if (c->sizes[0] + c->sizes[1] + c->sizes[2] > NUMBERS * v->values) return 0;
  if (nsdae_arena_fit(&c->memory[1], lay_out_values, c) < 0) return NSDAE_E_MEMORY;
  form(c);
  if (!factor(c)) return 0;
  condense_columns(c);
  condense_velocities(c, global->q);
  memset(c->base, 0, (size_t)v->m * sizeof *c->base);
  if (!condense_couplings(c)) return 0;
  c->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                        .contacts = p->contacts,
                                        .rows = p->rows,
                                        .mu = p->mu,
                                        .w = c->q,
                                        .compliance = p->compliance,
                                        .first = c->entry,
                                        .block = c->block,
                                        .value = c->W};
  return 1;
}

void nsdae_fc_condensed_correct(nsdae_fc_condensed *c, const double *r, const double *u)
{
  const nsdae_fc_view *v = &c->global->view;
  const nsdae_friction_problem *p = v->p;
  const double *W = c->W;
  memcpy(c->base, r, (size_t)v->m * sizeof *r);
  condense_velocities(c, u);
  for (int i = 0; i < p->contacts; i++)
    for (int k = v->row[i]; k < v->row[i + 1]; k++)
      if (p->compliance) c->q[k] -= p->compliance[k] * r[k];
  for (int i = 0; i < p->contacts; i++)
    for (const int *j = c->block + c->entry[i]; j < c->block + c->entry[i + 1]; j++)
      for (int k = v->row[i], rows = nsdae_fc_rows(p, *j); k < v->row[i + 1]; k++, W += rows)
        c->q[k] -= nsdae_dot(rows, W, r + v->row[*j]);
}

void nsdae_fc_condensed_multipliers(const nsdae_fc_condensed *c, double *r)
{
  const nsdae_fc_view *v = &c->global->view;
  int columns = v->row[v->p->contacts];
  double *l = r + columns;
  for (int i = 0; i < c->rows; i++) l[i] = -c->g[i];
  for (int k = 0; k < columns; k++)
    for (int e = c->column[k]; e < c->column[k + 1] && r[k] != c->base[k]; e++) {
      const double *T = c->T + c->part[e].at;
      for (int i = c->part[e].low; i < c->part[e].high; i++) l[i] -= *T++ * (r[k] - c->base[k]);
    }
  for (int i = c->rows - 1; i >= 0; i--) { /* R^T l := l */
    const double *R = c->S.R + c->S.at[i] - c->S.first[i];
    l[i] /= R[i];
    for (int j = c->S.first[i]; j < i; j++) l[j] -= R[j] * l[i];
  }
  for (int i = 0; i < c->rows; i++) l[i] += c->base[columns + i];
}
