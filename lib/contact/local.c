#include "local.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

void nsdae_local_prepare(nsdae_local *l, const nsdae_system *system, nsdae_error *error,
                         const nsdae_lcp_options *options, double rank_tol)
{
  l->model.dims.nt = system->dims.nt;
  l->model.blocks = (nsdae_blocks){1, l->ends, l->squares};
  l->blocks = system->blocks.count;
  l->terms.system = l->contacts.system = &l->model;
  l->terms.error = l->contacts.error = error;
  l->contacts.lcp.options = *options;
  l->contacts.rows_most = NSDAE_CLOSED_BASIS;
  l->kkt.rank_tol = rank_tol;
  l->kkt.blocks = &l->model.blocks;
}

static void most_dims(nsdae_local *l)
{
  int planar = l->model.dims.nt == 1 ? 3 : 1;
  l->model.dims.nv = l->kkt.n = l->ends[1] = NSDAE_LOCAL_V;
  l->model.dims.m = l->kkt.m = NSDAE_LOCAL_M;
  l->model.dims.k = NSDAE_LOCAL_ROWS / planar;
}

/* The arrays that a gathered island fills. */
static void lay_out_terms(nsdae_terms *T, nsdae_arena *arena)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_blocks *blocks = &T->system->blocks;
  long n = d->nv, k = d->k, nt = d->nt;
  T->M = NSDAE_ARENA_DOUBLES(arena, n * n);
  T->by.work = NSDAE_ARENA_DOUBLES(arena, n);
  nsdae_terms_layout_rows(&T->by.jacobian, blocks, d->m, 1, d->m, arena);
  T->w_N = NSDAE_ARENA_DOUBLES(arena, k);
  T->w_T = NSDAE_ARENA_DOUBLES(arena, k * nt);
  nsdae_terms_layout_rows(&T->by.normal, blocks, k, n, 1, arena);
  nsdae_terms_layout_rows(&T->by.tangent, blocks, k * nt, n, 1, arena);
}

void nsdae_local_layout(nsdae_local *l, nsdae_arena *arena)
{
  most_dims(l);
  const nsdae_dims *d = &l->model.dims;
  long k = d->k;
  lay_out_terms(&l->terms, arena);
  l->coefficient = nsdae_arena_take(arena, k, sizeof *l->coefficient);
  l->memory = NSDAE_ARENA_INTS(arena, k * NSDAE_CLOSED_BASIS);
  l->all = NSDAE_ARENA_INTS(arena, k);
  l->r = NSDAE_ARENA_DOUBLES(arena, d->nv);
  l->v = NSDAE_ARENA_DOUBLES(arena, d->nv);
  l->size = NSDAE_ARENA_DOUBLES(arena, d->nv);
  l->free = NSDAE_ARENA_DOUBLES(arena, d->nv);
  l->column = NSDAE_ARENA_DOUBLES(arena, d->nv);
  l->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  l->asked = NSDAE_ARENA_DOUBLES(arena, d->m);
  l->place = NSDAE_ARENA_INTS(arena, l->blocks);
  l->real_part = NSDAE_ARENA_DOUBLES(arena, 3 * k * (1 + d->nt));
  l->whole_part = NSDAE_ARENA_INTS(arena, 2 * k);
  nsdae_kkt_layout(&l->kkt, arena);
  l->model.contact = l->coefficient;
  l->contacts.law = l->law;
  l->contacts.rows_in_all = 0;
  for (int i = 0; i < d->k; i++) {
    l->law[i] = nsdae_law_make(d->nt == 1, d->nt == 1, 0, NULL);
    l->contacts.rows_in_all += l->law[i].rows;
  }
  for (int i = 0; l->all && i < d->k; i++) l->all[i] = 1;
  nsdae_contacts_layout(&l->contacts, arena);
}

int nsdae_local_fits(const nsdae_whole *w, int island)
{
  const nsdae_graph *is = w->islands;
  int k = nsdae_members_count(&is->contact, island), nt = w->system->dims.nt, n = 0;
  if (nsdae_members_count(&is->row, island) > NSDAE_LOCAL_M) return 0;
  if (k * (nt == 1 ? 3 : 1) > NSDAE_LOCAL_ROWS) return 0;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++)
    n += nsdae_blocks_size(&w->system->blocks, is->block.of[i]);
  if (n > NSDAE_LOCAL_V) return 0;
  for (int i = is->contact.first[island]; nt == 2 && i < is->contact.first[island + 1]; i++)
    if (w->law[is->contact.of[i]].mu > 0) return 0; /* a true cone */
  return 1;
}

/* ---- gathering */

static void place_impulses(nsdae_local *l)
{
  const nsdae_dims *d = &l->model.dims;
  size_t k = (size_t)d->k, kt = k * (size_t)d->nt;
  nsdae_impulses *r = &l->impulses;
  r->before = l->real_part;
  r->before_t = r->before + k;
  r->after = r->before_t + kt;
  r->after_t = r->after + k;
  r->normal = r->after_t + kt;
  r->tangential = r->normal + k;
  r->impact = l->whole_part;
  r->mode = r->impact + k;
}

/* M and r of the island's blocks as one dense matrix and vector. */
static void gather_blocks(nsdae_local *l, const nsdae_whole *w, int island)
{
  const nsdae_graph *is = w->islands;
  const nsdae_blocks *blocks = &w->system->blocks;
  int n = 0;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++) {
    l->place[is->block.of[i]] = n;
    n += nsdae_blocks_size(blocks, is->block.of[i]);
  }
  l->model.dims.nv = l->kkt.n = l->ends[1] = n;
  l->squares[1] = (size_t)n * (size_t)n;
  memset(l->terms.M, 0, (size_t)n * (size_t)n * sizeof *l->terms.M);
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++) {
    int b = is->block.of[i], at = l->place[b], size = nsdae_blocks_size(blocks, b);
    for (int j = 0; j < size; j++)
      memcpy(l->terms.M + (size_t)(at + j) * (size_t)n + at,
             w->M + blocks->square[b] + (size_t)j * (size_t)size, (size_t)size * sizeof *w->M);
    memcpy(l->r + at, w->r + blocks->first[b], (size_t)size * sizeof *w->r);
  }
}

static void gather_rows(nsdae_local *l, const nsdae_whole *w, int island)
{
  const nsdae_graph *is = w->islands;
  const int *row = is->row.of + is->row.first[island];
  int m = nsdae_members_count(&is->row, island), n = l->model.dims.nv;
  l->model.dims.m = l->kkt.m = m;
  l->terms.by.jacobian.stride = (size_t)m;
  memset(l->terms.by.jacobian.value, 0, (size_t)m * (size_t)n * sizeof *l->terms.by.jacobian.value);
  for (int i = 0; i < m; i++) {
    nsdae_rows_gather(&w->system->blocks, &w->terms->by.jacobian, row[i], l->place,
                      l->terms.by.jacobian.value + i, (size_t)m);
    l->asked[i] = w->lambda[row[i]];
  }
}

static void gather_laws(nsdae_local *l, const nsdae_whole *w, const int *contact)
{
  for (int i = 0; i < l->model.dims.k; i++) {
    l->coefficient[i] = w->law[contact[i]];
    l->law[i] = nsdae_law_make(l->model.dims.nt, l->coefficient[i].mu, 0, NULL);
  }
}

/* Contact a of the step as contact i of the island: directions over its velocities, offsets, warm
 * start. */
static void gather_contact(nsdae_local *l, const nsdae_whole *w, int i, int a)
{
  const nsdae_terms *T = w->terms;
  const nsdae_blocks *blocks = &w->system->blocks;
  int nt = l->model.dims.nt;
  size_t n = (size_t)l->model.dims.nv;
  l->terms.by.normal.at[i] = (size_t)i * n;
  nsdae_rows_gather(blocks, &T->by.normal, a, l->place, l->terms.by.normal.value + (size_t)i * n,
                    1);
  l->terms.w_N[i] = T->w_N[a];
  l->impulses.before[i] = w->results->before[a];
  for (int d = 0; d < nt; d++) {
    int to = i * nt + d, from = a * nt + d;
    l->terms.by.tangent.at[to] = (size_t)to * n;
    nsdae_rows_gather(blocks, &T->by.tangent, from, l->place,
                      l->terms.by.tangent.value + (size_t)to * n, 1);
    l->terms.w_T[to] = T->w_T[from];
    l->impulses.before_t[to] = w->results->before_t[from];
  }
  memcpy(l->memory + (size_t)i * NSDAE_CLOSED_BASIS,
         w->closed->basis + (size_t)a * NSDAE_CLOSED_BASIS, NSDAE_CLOSED_BASIS * sizeof(int));
}

static void gather_contacts(nsdae_local *l, const nsdae_whole *w, int island, int with_contacts)
{
  const nsdae_graph *is = w->islands;
  int k = with_contacts ? nsdae_members_count(&is->contact, island) : 0;
  const int *contact = is->contact.of + is->contact.first[island];
  size_t n = (size_t)l->model.dims.nv;
  l->model.dims.k = k;
  gather_laws(l, w, contact);
  place_impulses(l);
  nsdae_contacts_remember(&l->contacts, l->memory, NULL);
  nsdae_contacts_close_marked(&l->contacts, l->all, &l->impulses);
  memset(l->terms.by.normal.value, 0, n * (size_t)k * sizeof *l->terms.by.normal.value);
  memset(l->terms.by.tangent.value, 0,
         n * (size_t)k * (size_t)l->model.dims.nt * sizeof *l->terms.by.tangent.value);
  for (int i = 0; i < k; i++) gather_contact(l, w, i, contact[i]);
}

/* Whether something drives the island: a velocity is asked of a row or a contact. */
static int driven(const nsdae_local *l)
{
  int k = l->model.dims.k, kt = k * l->model.dims.nt;
  return nsdae_largest(l->kkt.m, l->asked) > 0 || nsdae_largest(k, l->terms.w_N) > 0 ||
         nsdae_largest(kt, l->terms.w_T) > 0;
}

/* Whether no entry moves a contact by more than the digits of the solution, in parts of the largest
 * velocity of a contact without impulses; each as if by the largest lever. */
static int stands(const nsdae_local *l)
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
static void stand(nsdae_local *l)
{
  size_t k = (size_t)l->model.dims.k, kt = k * (size_t)l->model.dims.nt;
  memset(l->v, 0, (size_t)l->kkt.n * sizeof *l->v);
  memset(l->impulses.after, 0, k * sizeof *l->impulses.after);
  memset(l->impulses.after_t, 0, kt * sizeof *l->impulses.after_t);
}

/* ---- residuals of the laws */

/* Of column j of W: W_j^T M^-1 W_j and the velocity without impulses, u_j being that of v. Where
 * there are no constraints the Delassus matrix has them. */
static void measure(const nsdae_local *l, int j, double u_j, double *diagonal, double *q)
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

/* Residual of contact i: impulses in units of velocity by the mean diagonal of G, against the law.
 */
static void fit_contact(const nsdae_local *l, int i, nsdae_misfit *misfit)
{
  const nsdae_impulses *r = &l->impulses;
  const nsdae_coefficients *law = &l->coefficient[i];
  int nt = l->model.dims.nt, columns = l->law[i].columns, first = l->contacts.first_column[i];
  double x[3] = {r->normal[i]}, u[3] = {r->after[i] + law->e_n * r->before[i]}, d = 0;
  for (int j = 1, t = i * nt; j < columns; j++, t++) {
    x[j] = r->tangential[t];
    u[j] = r->after_t[t] + law->e_t * r->before_t[t];
  }
  for (int j = 0; j < columns; j++) {
    double diagonal, q;
    measure(l, first + j, u[j], &diagonal, &q);
    nsdae_misfit_speed(misfit, q);
    d += diagonal;
  }
  if (columns > 1) d /= columns;
  for (int j = 0; j < columns; j++) x[j] *= d;
  nsdae_misfit_contact(misfit, columns > 1 ? law->mu : 0, x, u);
}

static void fit_row(const nsdae_local *l, int i, nsdae_misfit *misfit)
{
  const double *J = l->terms.by.jacobian.value + i;
  double u = -l->asked[i], change = 0;
  for (int j = 0; j < l->kkt.n; j++, J += l->kkt.m) {
    u += *J * l->v[j];
    change += *J * l->free[j];
  }
  nsdae_misfit_row(misfit, u);
  nsdae_misfit_speed(misfit, u + change);
}

/* Of v as it is, and what it would be without any impulse. */
static nsdae_misfit fit(const nsdae_local *l)
{
  nsdae_misfit misfit = {0};
  if (l->kkt.m > 0) {
    memcpy(l->free, l->r, (size_t)l->kkt.n * sizeof *l->free);
    nsdae_kkt_solve_mass(&l->kkt, l->free);
    for (int j = 0; j < l->kkt.n; j++) l->free[j] -= l->v[j];
  }
  for (int i = 0; i < l->model.dims.k; i++) fit_contact(l, i, &misfit);
  for (int i = 0; i < l->kkt.m; i++) fit_row(l, i, &misfit);
  return misfit;
}

/* ---- and back */

static void scatter_blocks(const nsdae_local *l, const nsdae_whole *w, int island)
{
  const nsdae_graph *is = w->islands;
  const nsdae_blocks *blocks = &w->system->blocks;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++) {
    int b = is->block.of[i];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof *w->v;
    memcpy(w->v + blocks->first[b], l->v + l->place[b], bytes);
    memcpy(w->size + blocks->first[b], l->size + l->place[b], bytes);
  }
  for (int i = 0; i < l->model.dims.m; i++)
    w->lambda[is->row.of[is->row.first[island] + i]] = l->lambda[i];
}

static void scatter_contact(const nsdae_local *l, const nsdae_whole *w, int i, int a)
{
  const nsdae_impulses *from = &l->impulses;
  nsdae_impulses *to = w->results;
  size_t nt = (size_t)l->model.dims.nt, t = (size_t)i * nt, u = (size_t)a * nt;
  to->normal[a] = from->normal[i];
  to->after[a] = from->after[i];
  to->mode[a] = from->mode[i];
  memcpy(to->tangential + u, from->tangential + t, nt * sizeof *to->tangential);
  memcpy(to->after_t + u, from->after_t + t, nt * sizeof *to->after_t);
  memcpy(w->closed->basis + (size_t)a * NSDAE_CLOSED_BASIS,
         l->memory + (size_t)i * NSDAE_CLOSED_BASIS, NSDAE_CLOSED_BASIS * sizeof(int));
}

/* The place goes before the text. */
static int failed(nsdae_local *l, const nsdae_whole *w, int island, int status)
{
  nsdae_error *error = l->terms.error;
  const nsdae_graph *is = w->islands;
  nsdae_error was = *error;
  int contacts = nsdae_members_count(&is->contact, island),
      b = is->block.of[is->block.first[island]];
  if (contacts > 0)
    nsdae_error_set(error, status, was.where, was.argument,
                    "in the island of block %d (%d contacts, first id %ld): %.150s", b, contacts,
                    w->closed->id[is->contact.of[is->contact.first[island]]], was.text);
  else
    nsdae_error_set(error, status, was.where, was.argument, "in the island of block %d: %.200s", b,
                    was.text);
  error->time = was.time;
  error->index = b;
  return status;
}

/* v, lambda, the impulses and the residuals of the laws, from the bases in memory. */
static int solve(nsdae_local *l, nsdae_misfit *misfit)
{
  int n = l->kkt.n, m = l->kkt.m;
  memcpy(l->lambda, l->asked, (size_t)m * sizeof *l->lambda);
  memcpy(l->v, l->r, (size_t)n * sizeof *l->v);
  memcpy(l->size, l->r, (size_t)n * sizeof *l->size);
  int status = nsdae_terms_solve(&l->terms, &l->kkt, 1, l->v, l->lambda);
  if (status < 0) return status;
  nsdae_kkt_solve_mass(&l->kkt, l->size);
  status = nsdae_contacts_solve(&l->contacts, &l->terms, &l->kkt, l->size, l->v, l->lambda);
  if (status < 0 || !nsdae_contacts_any(&l->contacts)) return status;
  if (!driven(l) && stands(l)) stand(l);
  *misfit = fit(l);
  return status;
}

/* Whether the normal impulses are what they were, up to rounding. */
static int same_impulses(const nsdae_local *l, const double *was)
{
  double apart = 0, most = nsdae_largest(l->model.dims.k, was);
  for (int i = 0; i < l->model.dims.k; i++)
    apart = fmax(apart, fabs(l->impulses.normal[i] - was[i]));
  return apart <= 1e-3 * most;
}

/* The complementarity problem is judged by scales of its own: where it is solved and a law is not,
 * once more and by two digits more. Where that fails or finds another solution, it was one. */
static int solve_laws(nsdae_local *l, nsdae_misfit *misfit)
{
  int memory[NSDAE_LOCAL_ROWS * NSDAE_CLOSED_BASIS];
  double was[NSDAE_LOCAL_ROWS];
  const size_t bytes = (size_t)l->model.dims.k * NSDAE_CLOSED_BASIS * sizeof *memory;
  double *tol = &l->contacts.lcp.options.tol, asked = *tol;
  memcpy(memory, l->memory, bytes);
  int status = solve(l, misfit);
  if (status < 0 || nsdae_misfit_residual(misfit) <= asked) return status;
  memcpy(was, l->impulses.normal, (size_t)l->model.dims.k * sizeof *was);
  *tol = 1e-2 * asked;
  status = solve(l, misfit);
  *tol = asked;
  if (status == NSDAE_OK && same_impulses(l, was)) return status;
  memcpy(l->memory, memory, bytes);
  return solve(l, misfit);
}

int nsdae_local_solve(nsdae_local *l, const nsdae_whole *w, int island, int with_contacts,
                      int least_norm, nsdae_misfit *misfit)
{
  const nsdae_graph *is = w->islands;
  l->model.part = (nsdae_part_of){w->system,
                                  is->block.of + is->block.first[island],
                                  is->row.of + is->row.first[island],
                                  is->contact.of + is->contact.first[island],
                                  w->closed->id,
                                  nsdae_members_count(&is->block, island)};
  gather_blocks(l, w, island);
  gather_rows(l, w, island);
  gather_contacts(l, w, island, with_contacts);
  l->terms.t = w->terms->t;
  l->model.epoch = w->system->epoch;
  int status = nsdae_terms_factor(&l->terms, l->terms.M, &l->kkt, least_norm);
  if (status == NSDAE_OK) status = solve_laws(l, misfit);
  if (status < 0) return failed(l, w, island, status);
  scatter_blocks(l, w, island);
  for (int i = 0; i < l->model.dims.k; i++)
    scatter_contact(l, w, i, is->contact.of[is->contact.first[island] + i]);
  return NSDAE_OK;
}
