#include "island.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "vector.h"

/* Sizes of the island. A block comes for the first time where its number is that of the blocks so
 * far: so they are numbered. */
static void count(nsdae_fc *c)
{
  const nsdae_fc_whole *w = c->whole;
  const nsdae_friction_problem *p = w->view.p;
  c->start = w->start[c->label];
  c->n = w->start[c->label + 1] - c->start;
  c->entries = c->blocks = c->ny = 0;
  c->values = 0;
  for (int k = 0; k < c->n; k++) {
    int i = w->member[c->start + k];
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int b = p->block[e];
      if (w->number[b] < 0) continue; /* a part of zeros */
      c->entries++;
      c->values += 3 * (size_t)(c->local ? 3 : p->size[b]);
      if (c->local || w->number[b] != c->blocks) continue;
      c->blocks++;
      c->ny += p->size[b];
    }
  }
  if (c->local) c->blocks = c->n, c->ny = 3 * c->n;
}

void nsdae_fc_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc *c = object;
  const nsdae_friction_problem *p = c->whole->view.p;
  c->local = p->form == NSDAE_FRICTION_LOCAL;
  c->compliant = p->compliance != NULL;
  count(c);
  int n = c->n;
  c->item = NSDAE_ARENA_INTS(arena, n);
  c->kind = NSDAE_ARENA_INTS(arena, n);
  c->mu = NSDAE_ARENA_DOUBLES(arena, n);
  c->weight = NSDAE_ARENA_DOUBLES(arena, n);
  c->factor = NSDAE_ARENA_DOUBLES(arena, n);
  c->turn = NSDAE_ARENA_DOUBLES(arena, 2L * n);
  c->q = NSDAE_ARENA_DOUBLES(arena, 3L * n);
  c->C = NSDAE_ARENA_DOUBLES(arena, 3L * n);
  c->D = NSDAE_ARENA_DOUBLES(arena, 9L * n);
  c->first = NSDAE_ARENA_INTS(arena, n + 1L);
  c->block = NSDAE_ARENA_INTS(arena, c->entries);
  c->at = nsdae_arena_take(arena, c->entries + 1L, sizeof(size_t));
  c->J = NSDAE_ARENA_DOUBLES(arena, c->values);
  c->size = NSDAE_ARENA_INTS(arena, c->blocks);
  c->offset = NSDAE_ARENA_INTS(arena, c->blocks + 1L);
  c->r = NSDAE_ARENA_DOUBLES(arena, 3L * n);
  c->u = NSDAE_ARENA_DOUBLES(arena, 3L * n);
  c->y = c->local ? c->r : NSDAE_ARENA_DOUBLES(arena, c->ny);
}

/* Kind, scale and frame (not yet turned) of item number k. */
static void fill_item(nsdae_fc *c, int k, int i)
{
  const nsdae_fc_whole *w = c->whole;
  const nsdae_friction_problem *p = w->view.p;
  int rows = nsdae_fc_rows(p, i);
  double size = sqrt(w->d[i] / w->most_d);
  c->item[k] = i;
  c->mu[k] = i < p->contacts && rows > 1 ? p->mu[i] : 0;
  c->kind[k] = i >= p->contacts ? NSDAE_FC_BILATERAL
               : c->mu[k] > 0   ? NSDAE_FC_CONE
                                : NSDAE_FC_NORMAL;
  c->weight[k] = size;
  c->factor[k] = w->scale / size / w->most_d;
  c->turn[2 * k] = 1;
  c->turn[2 * k + 1] = 0;
  for (int j = 0; j < 3; j++) {
    int has = j < rows;
    c->q[3 * k + j] = has ? w->q[w->view.row[i] + j] / (w->scale * size) : 0;
    c->C[3 * k + j] = has && c->compliant ? p->compliance[w->view.row[i] + j] / w->d[i] : 0;
  }
}

static void fill_sizes(nsdae_fc *c)
{
  const nsdae_fc_whole *w = c->whole;
  const nsdae_friction_problem *p = w->view.p;
  for (int k = 0; k < c->n; k++)
    for (int e = p->first[c->item[k]]; e < p->first[c->item[k] + 1]; e++)
      if (w->number[p->block[e]] >= 0)
        c->size[w->number[p->block[e]]] = c->local ? 3 : p->size[p->block[e]];
  for (int b = 0; b < c->blocks && c->local; b++) c->size[b] = 3;
  c->offset[0] = 0;
  for (int b = 0; b < c->blocks; b++) c->offset[b + 1] = c->offset[b] + c->size[b];
}

/* J' = sqrt(D / d) J / sqrt(D) of part e of the whole; local: W' = W / sqrt(d_i d_j). */
static void fill_part(const nsdae_fc *c, int k, int e, double *J)
{
  const nsdae_fc_whole *w = c->whole;
  const nsdae_friction_problem *p = w->view.p;
  int i = c->item[k], b = p->block[e], rows = nsdae_fc_rows(p, i);
  int n = c->local ? 3 : p->size[b], have = c->local ? nsdae_fc_rows(p, b) : n;
  const double *from = (c->local ? p->value : w->J) + w->view.at[e];
  double scale = 1 / sqrt(w->d[i]) / (c->local ? sqrt(w->d[b]) : 1);
  for (int j = 0; j < 3; j++)
    for (int l = 0; l < n; l++)
      J[j * n + l] = j < rows && l < have ? scale * from[j * have + l] : 0;
}

static void fill_parts(nsdae_fc *c)
{
  const nsdae_friction_problem *p = c->whole->view.p;
  int f = 0;
  c->at[0] = 0;
  c->first[0] = 0;
  for (int k = 0; k < c->n; k++) {
    int i = c->item[k];
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int b = c->whole->number[p->block[e]];
      if (b < 0) continue;
      c->block[f] = b;
      c->at[f + 1] = c->at[f] + 3 * (size_t)c->size[b];
      fill_part(c, k, e, c->J + c->at[f]);
      f++;
    }
    c->first[k + 1] = f;
  }
}

static void diagonal(nsdae_fc *c, int k)
{
  double *D = c->D + 9 * (size_t)k;
  memset(D, 0, 9 * sizeof *D);
  for (int j = 0; j < 3; j++) D[4 * j] = c->C[3 * k + j];
  for (int e = c->first[k]; e < c->first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e);
    int n = c->size[c->block[e]];
    if (c->local && c->block[e] != k) continue;
    for (int j = 0; j < 3; j++)
      for (int l = 0; l < 3; l++)
        D[3 * j + l] +=
            c->local ? (J[3 * j + l] + J[3 * l + j]) / 2 : nsdae_dot(n, J + j * n, J + l * n);
  }
}

/* a, b := cos a + sin b, -sin a + cos b */
static void turn(const double *by, double *a, double *b)
{
  double x = *a;
  *a = by[0] * x + by[1] * *b;
  *b = by[0] * *b - by[1] * x;
}

/* The turn that makes the tangential part of D diagonal (Golub and Van Loan, 8.5: one Jacobi
 * rotation). Compliance must not mix: its two entries would. */
static void find_turn(nsdae_fc *c, int k)
{
  const double *D = c->D + 9 * (size_t)k;
  if (D[5] == 0 || c->C[3 * k + 1] != c->C[3 * k + 2]) return;
  double angle = 0.5 * atan2(2 * D[5], D[4] - D[8]);
  c->turn[2 * k] = cos(angle);
  c->turn[2 * k + 1] = sin(angle);
}

/* Rows of J of every item; in the local form columns too. */
static void turn_all(nsdae_fc *c)
{
  for (int k = 0; k < c->n; k++) {
    turn(c->turn + 2 * k, c->q + 3 * k + 1, c->q + 3 * k + 2);
    for (int e = c->first[k]; e < c->first[k + 1]; e++) {
      int b = c->block[e], n = c->size[b];
      double *J = c->J + c->at[e];
      for (int l = 0; l < n; l++) turn(c->turn + 2 * k, J + n + l, J + 2 * n + l);
      for (int j = 0; j < 3 && c->local; j++) turn(c->turn + 2 * b, J + 3 * j + 1, J + 3 * j + 2);
    }
    diagonal(c, k);
  }
}

void nsdae_fc_fill(nsdae_fc *c, const double *r)
{
  const nsdae_fc_whole *w = c->whole;
  for (int k = 0; k < c->n; k++) fill_item(c, k, w->member[c->start + k]);
  fill_sizes(c);
  fill_parts(c);
  for (int k = 0; k < c->n; k++) {
    diagonal(c, k);
    if (c->kind[k] == NSDAE_FC_CONE) find_turn(c, k);
  }
  turn_all(c);
  for (int k = 0; k < c->n; k++) {
    int rows = nsdae_fc_rows(w->view.p, c->item[k]);
    for (int j = 0; j < 3; j++)
      c->r[3 * k + j] = j < rows ? r[w->view.row[c->item[k]] + j] / c->factor[k] : 0;
    turn(c->turn + 2 * k, c->r + 3 * k + 1, c->r + 3 * k + 2);
  }
}

void nsdae_fc_scatter(const nsdae_fc *c, const double *from, double *r)
{
  const nsdae_fc_whole *w = c->whole;
  for (int k = 0; k < c->n; k++) {
    int rows = nsdae_fc_rows(w->view.p, c->item[k]);
    double back[2] = {c->turn[2 * k], -c->turn[2 * k + 1]}, x[3];
    memcpy(x, from + 3 * k, sizeof x);
    turn(back, x + 1, x + 2);
    for (int j = 0; j < rows; j++) r[w->view.row[c->item[k]] + j] = c->factor[k] * x[j];
  }
}

void nsdae_fc_velocities(const nsdae_fc *c, const double *r, double *y, double *u)
{
  const double *from = c->local ? r : y;
  if (!c->local) {
    memset(y, 0, (size_t)c->ny * sizeof *y);
    for (int k = 0; k < c->n; k++)
      for (int e = c->first[k]; e < c->first[k + 1]; e++)
        nsdae_add_product(c->size[c->block[e]], 3, nsdae_fc_part(c, e), r + 3 * k,
                          y + c->offset[c->block[e]]);
  }
  for (int k = 0; k < c->n; k++) {
    for (int j = 0; j < 3; j++) u[3 * k + j] = c->q[3 * k + j] + c->C[3 * k + j] * r[3 * k + j];
    for (int e = c->first[k]; e < c->first[k + 1]; e++)
      nsdae_add_transposed(c->size[c->block[e]], 3, 1, nsdae_fc_part(c, e),
                           from + c->offset[c->block[e]], u + 3 * k);
  }
}

double nsdae_fc_residual(const nsdae_fc *c, const double *r, const double *u)
{
  double most = 0;
  for (int k = 0; k < c->n; k++) {
    double one = c->weight[k] * nsdae_fc_natural(c->kind[k], c->mu[k], r + 3 * k, u + 3 * k);
    if (!(one <= most)) most = one;
    if (most != most) return NAN;
  }
  return most;
}
