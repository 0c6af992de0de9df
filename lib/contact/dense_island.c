#include "dense_island.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

void nsdae_dense_island_prepare(nsdae_dense_island *l, const nsdae_system *system,
                                nsdae_error *error, const nsdae_lcp_options *options,
                                double rank_tol)
{
  l->blocks = (nsdae_blocks){1, l->ends, l->squares};
  l->contacts.system = system;
  l->contacts.error = error;
  l->contacts.lcp.options = *options;
  l->contacts.rows_most = NSDAE_CLOSED_BASIS;
  l->contacts.part.J = &l->J;
  l->kkt.rank_tol = rank_tol;
  l->kkt.blocks = &l->blocks;
}

void nsdae_dense_island_layout(nsdae_dense_island *l, nsdae_arena *arena)
{
  const nsdae_system *s = l->contacts.system;
  int planar = s->dims.nt == 1 ? 3 : 1;
  const nsdae_dims most = {
      .nv = NSDAE_DENSE_V, .m = NSDAE_DENSE_M, .k = NSDAE_DENSE_ROWS / planar, .nt = s->dims.nt};
  l->kkt.n = l->ends[1] = most.nv;
  l->kkt.m = most.m;
  l->contacts.rows_in_all = NSDAE_DENSE_ROWS;
  double **vector[] = {&l->r, &l->v, &l->size, &l->free, &l->column};
  for (int i = 0; i < 5; i++) *vector[i] = NSDAE_ARENA_DOUBLES(arena, most.nv);
  l->gathered = NSDAE_ARENA_DOUBLES(arena, most.nv * most.nv);
  l->lambda = NSDAE_ARENA_DOUBLES(arena, most.m);
  l->asked = NSDAE_ARENA_DOUBLES(arena, most.m);
  l->place = NSDAE_ARENA_INTS(arena, s->blocks.count);
  l->contacts.part.place = l->place;
  nsdae_terms_layout_rows(&l->J, &l->blocks, most.m, 1, most.m, arena);
  nsdae_kkt_layout(&l->kkt, arena);
  nsdae_contacts_layout(&l->contacts, &most, arena);
}

int nsdae_dense_island_fits(const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  int k = nsdae_members_count(&is->contact, island), nt = w->system->dims.nt, n = 0;
  if (nsdae_members_count(&is->row, island) > NSDAE_DENSE_M) return 0;
  if (k * (nt == 1 ? 3 : 1) > NSDAE_DENSE_ROWS) return 0;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++)
    n += nsdae_blocks_size(&w->system->blocks, is->block.of[i]);
  if (n > NSDAE_DENSE_V) return 0;
  for (int i = is->contact.first[island]; nt == 2 && i < is->contact.first[island + 1]; i++)
    if (w->law[is->contact.of[i]].mu > 0) return 0; /* a true cone */
  return 1;
}

/* ---- gathering */

/* Of one block M is that of the whole. */
static void gather_blocks(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->block;
  const nsdae_blocks *blocks = &w->system->blocks;
  const int *block = members->of + members->first[island];
  int count = nsdae_members_count(members, island), n = 0;
  for (int i = 0; i < count; i++) {
    l->place[block[i]] = n;
    memcpy(l->r + n, w->r + blocks->first[block[i]],
           (size_t)nsdae_blocks_size(blocks, block[i]) * sizeof *w->r);
    n += nsdae_blocks_size(blocks, block[i]);
  }
  l->kkt.n = l->ends[1] = n;
  l->squares[1] = (size_t)n * (size_t)n;
  l->M = count == 1 ? w->M + blocks->square[*block] : l->gathered;
  if (count == 1) return;
  memset(l->gathered, 0, l->squares[1] * sizeof *l->gathered);
  for (int i = 0; i < count; i++) {
    int at = l->place[block[i]], size = nsdae_blocks_size(blocks, block[i]);
    const double *M = w->M + blocks->square[block[i]];
    for (int j = 0; j < size; j++)
      memcpy(l->gathered + (size_t)(at + j) * (size_t)n + at, M + (size_t)j * (size_t)size,
             (size_t)size * sizeof *M);
  }
}

static void gather_rows(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  const int *row = is->row.of + is->row.first[island];
  int m = nsdae_members_count(&is->row, island);
  l->kkt.m = l->J.count = m;
  l->J.stride = (size_t)m;
  memset(l->J.value, 0, (size_t)m * (size_t)l->kkt.n * sizeof *l->J.value);
  for (int i = 0; i < m; i++) {
    nsdae_rows_gather(&w->system->blocks, &w->terms->by.jacobian, row[i], l->place, l->J.value + i,
                      (size_t)m);
    l->asked[i] = w->lambda[row[i]];
  }
}

static void close_contacts(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->contact;
  nsdae_contacts *c = &l->contacts;
  c->part.coefficient = w->law;
  c->part.id = w->closed->id;
  nsdae_contacts_remember(c, w->closed->basis, NULL);
  nsdae_contacts_close_these(c, w->with_contacts ? nsdae_members_count(members, island) : 0,
                             members->of + members->first[island], w->results);
}

/* Whether something drives the island: a velocity is asked of a row or a contact. */
static int driven(const nsdae_dense_island *l, const nsdae_island_equations *w)
{
  const nsdae_contacts *c = &l->contacts;
  const nsdae_terms *T = w->terms;
  int nt = w->system->dims.nt, any = nsdae_largest(l->kkt.m, l->asked) > 0;
  for (int a = 0; a < c->active_count && !any; a++)
    any = T->w_N[c->active[a]] != 0 || nsdae_largest(nt, T->w_T + c->active[a] * nt) > 0;
  return any;
}

/* Whether no entry moves a contact by more than the digits of the solution, in parts of the largest
 * velocity of a contact without impulses; each as if by the largest lever. */
static int stands(const nsdae_dense_island *l)
{
  const nsdae_contacts *c = &l->contacts;
  const double *W = c->delassus.W, digits = fmin(c->lcp.options.tol, NSDAE_STILL);
  double fastest = nsdae_largest(l->kkt.n, l->v),
         speed = nsdae_largest(c->columns, c->delassus.offset);
  if (!(fastest <= digits * speed)) return 0;
  double lever = nsdae_largest(c->columns * l->kkt.n, W);
  return fastest * lever <= digits * speed;
}

/* Exactly: it does not creep. */
static void stand(nsdae_dense_island *l)
{
  const nsdae_contacts *c = &l->contacts;
  int nt = c->system->dims.nt;
  memset(l->v, 0, (size_t)l->kkt.n * sizeof *l->v);
  for (int a = 0; a < c->active_count; a++) {
    c->results->after[c->active[a]] = 0;
    for (int j = 0; j < nt; j++) c->results->after_t[c->active[a] * nt + j] = 0;
  }
}

/* ---- residuals of the laws */

/* Of column j of W: W_j^T M^-1 W_j and the velocity without impulses, u_j being that of v. Where
 * there are no constraints the Delassus matrix has them. */
static void measure(const nsdae_dense_island *l, int j, double u_j, double *diagonal, double *q)
{
  const nsdae_delassus *d = &l->contacts.delassus;
  int n = l->kkt.n;
  const double *W = d->W + (size_t)j * (size_t)n;
  *diagonal = d->G[(size_t)j * (size_t)(l->contacts.columns + 1)];
  *q = d->offset[j];
  if (l->kkt.m == 0) return;
  memcpy(l->column, W, (size_t)n * sizeof *W);
  nsdae_kkt_solve_mass(&l->kkt, l->column);
  *diagonal = nsdae_dot(n, W, l->column);
  *q = u_j + nsdae_dot(n, W, l->free);
}

/* Residual of the a-th contact: impulses in units of velocity by the mean diagonal of G, against
 * the law. */
static void fit_contact(const nsdae_dense_island *l, int a, nsdae_natural_residual *residual)
{
  const nsdae_contacts *c = &l->contacts;
  const nsdae_impulses *r = c->results;
  int i = c->active[a], nt = c->system->dims.nt, columns = c->law[a].columns;
  const nsdae_coefficients *law = &c->part.coefficient[i];
  double x[3] = {r->normal[i]}, u[3] = {r->after[i] + law->e_n * r->before[i]}, d = 0;
  for (int j = 1, t = i * nt; j < columns; j++, t++) {
    x[j] = r->tangential[t];
    u[j] = r->after_t[t] + law->e_t * r->before_t[t];
  }
  for (int j = 0; j < columns; j++) {
    double diagonal, q;
    measure(l, c->first_column[a] + j, u[j], &diagonal, &q);
    nsdae_natural_residual_speed(residual, q);
    d += diagonal;
  }
  if (columns > 1) d /= columns;
  for (int j = 0; j < columns; j++) x[j] *= d;
  nsdae_natural_residual_contact(residual, columns > 1 ? law->mu : 0, x, u);
}

static void fit_row(const nsdae_dense_island *l, int i, nsdae_natural_residual *residual)
{
  const double *J = l->J.value + i;
  double u = -l->asked[i], change = 0;
  for (int j = 0; j < l->kkt.n; j++, J += l->kkt.m) {
    u += *J * l->v[j];
    change += *J * l->free[j];
  }
  nsdae_natural_residual_row(residual, u);
  nsdae_natural_residual_speed(residual, u + change);
}

/* Of v as it is, and what it would be without any impulse. */
static nsdae_natural_residual fit(const nsdae_dense_island *l)
{
  nsdae_natural_residual residual = {0};
  if (l->kkt.m > 0) {
    memcpy(l->free, l->r, (size_t)l->kkt.n * sizeof *l->free);
    nsdae_kkt_solve_mass(&l->kkt, l->free);
    for (int j = 0; j < l->kkt.n; j++) l->free[j] -= l->v[j];
  }
  for (int a = 0; a < l->contacts.active_count; a++) fit_contact(l, a, &residual);
  for (int i = 0; i < l->kkt.m; i++) fit_row(l, i, &residual);
  return residual;
}

/* ---- and back */

static void scatter(const nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  const nsdae_blocks *blocks = &w->system->blocks;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++) {
    int b = is->block.of[i];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof *w->v;
    memcpy(w->v + blocks->first[b], l->v + l->place[b], bytes);
    memcpy(w->size + blocks->first[b], l->size + l->place[b], bytes);
  }
  for (int i = 0; i < l->kkt.m; i++)
    w->lambda[is->row.of[is->row.first[island] + i]] = l->lambda[i];
}

/* v, lambda, the impulses and the residuals of the laws, from the bases in memory. */
static int solve(nsdae_dense_island *l, const nsdae_island_equations *w,
                 nsdae_natural_residual *residual)
{
  memcpy(l->lambda, l->asked, (size_t)l->kkt.m * sizeof *l->lambda);
  int status = nsdae_contacts_step(&l->contacts, w->terms, &l->kkt, l->r, l->v, l->size, l->lambda);
  if (status < 0 || !nsdae_contacts_any(&l->contacts)) return status;
  if (!driven(l, w) && stands(l)) stand(l);
  *residual = fit(l);
  return status;
}

/* Whether the normal impulses are what they were, up to rounding. */
static int same_impulses(const nsdae_dense_island *l, const double *was)
{
  const nsdae_contacts *c = &l->contacts;
  double apart = 0, most = nsdae_largest(c->active_count, was);
  for (int a = 0; a < c->active_count; a++)
    apart = fmax(apart, fabs(c->results->normal[c->active[a]] - was[a]));
  return apart <= 1e-3 * most;
}

/* Bases of the closed contacts, from or to their place. */
static void copy_bases(nsdae_contacts *c, int *basis, int back)
{
  const size_t bytes = NSDAE_CLOSED_BASIS * sizeof *basis;
  for (int a = 0; a < c->active_count; a++, basis += NSDAE_CLOSED_BASIS) {
    int *of = c->warm.basis + (size_t)c->active[a] * NSDAE_CLOSED_BASIS;
    memcpy(back ? of : basis, back ? basis : of, bytes);
  }
}

/* The complementarity problem is judged by scales of its own: if it is solved and a law is not,
 * once more and by two digits more. If that fails or finds another solution, it was one. */
static int solve_laws(nsdae_dense_island *l, const nsdae_island_equations *w,
                      nsdae_natural_residual *residual)
{
  nsdae_contacts *c = &l->contacts;
  int basis[NSDAE_DENSE_ROWS * NSDAE_CLOSED_BASIS];
  double was[NSDAE_DENSE_ROWS], *tol = &c->lcp.options.tol, asked = *tol;
  copy_bases(c, basis, 0);
  int status = solve(l, w, residual);
  if (status < 0 || nsdae_natural_residual_scaled(residual) <= asked) return status;
  for (int a = 0; a < c->active_count; a++) was[a] = c->results->normal[c->active[a]];
  *tol = 1e-2 * asked;
  status = solve(l, w, residual);
  *tol = asked;
  if (status == NSDAE_OK && same_impulses(l, was)) return status;
  copy_bases(c, basis, 1);
  return solve(l, w, residual);
}

int nsdae_dense_island_solve(nsdae_dense_island *l, const nsdae_island_equations *w, int island,
                             int least_norm, nsdae_natural_residual *residual)
{
  gather_blocks(l, w, island);
  gather_rows(l, w, island);
  close_contacts(l, w, island);
  int status = nsdae_kkt_factor(&l->kkt, l->M, &l->J);
  if (status == NSDAE_OK && l->kkt.rank < l->kkt.m && !least_norm) status = NSDAE_E_RANK;
  if (status == NSDAE_OK) status = solve_laws(l, w, residual);
  if (status == NSDAE_OK) scatter(l, w, island);
  return status;
}
