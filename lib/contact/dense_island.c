#include "dense_residual.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "listed.h"
#include "slides.h"
#include "vector.h"

void nsdae_dense_island_prepare(nsdae_dense_island *l, const nsdae_contacts *of, nsdae_error *error,
                                double rank_tol)
{
  nsdae_contacts *c = &l->contacts;
  nsdae_contacts_set(c, of->system, error, &of->lcp.accuracy, of->edges);
  c->rows_most = of->rows_most;
  c->part.J = &l->gathered.J;
  l->kkt.rank_tol = rank_tol;
  l->factored = l->closed = -1;
}

/* ---- room */

/* Whether an island of any size is dense. */
static int is_any_size(const nsdae_contacts *c)
{
  int loaded = 0;
  for (int j = 0; j < c->system->dims.f; j++) loaded |= c->system->frictional_joint[j].mu > 0;
  return loaded || nsdae_contacts_polygons(c);
}

/* What no island that fits exceeds, but those of any size of contact lists. */
static nsdae_dense_size first_size(const nsdae_contacts *c, const nsdae_room *rows)
{
  const nsdae_system *s = c->system;
  const nsdae_dims *d = &s->dims;
  int one = s->blocks.count == 1, planar = d->nt == 1 ? 3 : 1;
  int most = nsdae_terms_most(s), bounded = most < NSDAE_ANY_NUMBER;
  int all = bounded && (is_any_size(c) || (one && c->slides.count > 0));
  int few = one || c->slides.count > 0 ? NSDAE_DENSE_ONE : NSDAE_DENSE_ROWS;
  nsdae_dense_size size = {.n = d->nv, .m = d->m, .contacts = few / planar, .rows = few};
  if (!one && !all)
    size.n = nsdae_fewer(d->nv, d->m + d->f > 0 ? NSDAE_DENSE_JOINTED : NSDAE_DENSE_V);
  if (!one && !all) size.m = nsdae_fewer(d->m, NSDAE_DENSE_JOINTED);
  size.contacts = all ? most : nsdae_fewer(most, size.contacts);
  long rows_in_all = nsdae_contacts_rows(s, c->edges); /* but those of a list */
  if (!bounded || all || rows_in_all < few) size.rows = (bounded ? 0 : few) + (int)rows_in_all;
  if (!one && s->call.constraint_rows) size.parts = (int)rows->entries;
  if (!one && !s->call.constraint_rows) size.parts = d->m * s->blocks.count;
  return size;
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_dense_island *l = object;
  const nsdae_dense_size *most = &l->most;
  nsdae_contacts *c = &l->contacts;
  nsdae_gathered *g = &l->gathered;
  const nsdae_system *s = c->system;
  const nsdae_dims dims = {
      .nv = most->n, .m = most->m, .k = most->contacts, .nt = s->dims.nt, .f = s->dims.f};
  long blocks = s->blocks.count > 1 ? s->blocks.count : 0, n = blocks > 0 ? most->n : 0;
  int joints = c->slides.count;
  nsdae_arena_doubles(arena, n, (double **[]){&g->r, &g->v, &g->size, NULL});
  g->M = NSDAE_ARENA_DOUBLES(arena, n * n);
  g->lambda = NSDAE_ARENA_DOUBLES(arena, n > 0 ? most->m : 0);
  g->start = NSDAE_ARENA_INTS(arena, blocks);
  g->blocks.first = NSDAE_ARENA_INTS(arena, n + 1);
  g->blocks.square = nsdae_arena_take(arena, n + 1, sizeof *g->blocks.square);
  g->J.first = NSDAE_ARENA_INTS(arena, most->m + 1L);
  g->J.block = NSDAE_ARENA_INTS(arena, most->parts);
  g->J.at = nsdae_arena_take(arena, most->parts, sizeof *g->J.at);
  nsdae_arena_doubles(arena, most->n, (double **[]){&l->free, &l->column, NULL});
  l->asked = NSDAE_ARENA_DOUBLES(arena, most->m);
  l->was = NSDAE_ARENA_DOUBLES(arena, most->contacts);
  l->basis = NSDAE_ARENA_INTS(arena, most->contacts * (long)c->rows_most + 3L * joints);
  l->kkt.n = most->n;
  l->kkt.m = most->m;
  l->kkt.blocks = &s->blocks;
  nsdae_kkt_layout_most(&l->kkt, s->dims.m, arena);
  c->rows_in_all = most->rows;
  c->cones.most = joints > 0 && s->dims.nt == 2 && c->edges == 0 ? most->contacts : 0;
  nsdae_contacts_layout(c, &dims, arena);
}

static void widen(nsdae_dense_size *to, const nsdae_dense_size *other)
{
  if (other->n > to->n) to->n = other->n;
  if (other->m > to->m) to->m = other->m;
  if (other->parts > to->parts) to->parts = other->parts;
  if (other->contacts > to->contacts) to->contacts = other->contacts;
  if (other->rows > to->rows) to->rows = other->rows;
}

int nsdae_dense_island_grow(nsdae_dense_island *l, const nsdae_room *rows)
{
  nsdae_contacts *c = &l->contacts;
  nsdae_dense_size size = l->most, first;
  c->slides.count = 0;
  for (int j = 0; j < c->system->dims.f; j++)
    c->slides.count += nsdae_system_joint_rubs(c->system, j);
  first = first_size(c, rows);
  widen(&size, &first);
  widen(&size, &l->need);
  if (l->arena.base && memcmp(&size, &l->most, sizeof size) == 0) return NSDAE_OK;
  nsdae_dense_island before = *l; /* it stays if there is no memory */
  l->most = size;
  l->factored = l->closed = -1;
  l->arena = (nsdae_arena){0};
  int status = nsdae_arena_build(&l->arena, layout, l);
  c->active_count = 0;
  if (status == NSDAE_OK) status = nsdae_cones_open(&c->cones);
  nsdae_arena_release(status == NSDAE_OK ? &before.arena : &l->arena);
  before.contacts.cones.solver = c->cones.solver; /* it has memory of its own */
  if (status < 0) *l = before;
  return status;
}

void nsdae_dense_island_release(nsdae_dense_island *l)
{
  nsdae_arena_release(&l->arena);
  nsdae_kkt_release(&l->kkt);
  nsdae_cones_close(&l->contacts.cones);
}

/* Rows of the complementarity problem of an island. */
static int count_rows(const nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_members *m = &w->islands->contact;
  int rows = 3 * nsdae_members_count(&w->islands->joint, island);
  for (int i = m->first[island]; i < m->first[island + 1]; i++)
    rows += nsdae_law_rows(w->system->dims.nt, w->law[m->of[i]].mu, l->contacts.edges);
  return rows;
}

/* Of islands of any size, whether there is room. */
static int enough(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  const nsdae_dense_size *most = &l->most;
  nsdae_dense_size size = {.contacts = nsdae_members_count(&is->contact, island),
                           .m = nsdae_members_count(&is->row, island)};
  if (l->contacts.edges == 0 && is->joints == 0) return 1;
  size.n = nsdae_island_size(w, island);
  size.rows = count_rows(l, w, island);
  if (size.n <= most->n && size.m <= most->m && size.contacts <= most->contacts &&
      size.rows <= most->rows)
    return 1;
  size.contacts += size.contacts / 2;
  size.rows += size.rows / 2;
  widen(&l->need, &size);
  return 0;
}

static int with_friction(const nsdae_island_equations *w, int island)
{
  const nsdae_members *m = &w->islands->contact;
  for (int i = m->first[island]; i < m->first[island + 1]; i++)
    if (w->law[m->of[i]].mu > 0) return 1;
  return 0;
}

/* Whether all joints are position motors. */
static int has_motors_alone(const nsdae_island_equations *w, int island)
{
  const nsdae_members *m = &w->islands->joint;
  for (int i = m->first[island]; i < m->first[island + 1]; i++)
    if (!w->system->frictional_joint[w->islands->joint_number[m->of[i]]].position) return 0;
  return 1;
}

/* Joints with a load, and those beside polygons, are dense whatever their size. Position motors
 * beside cones are rows of these. */
static int fits_joints(const nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  if (w->islands->blocks == 1 || is_any_size(&l->contacts)) return 1;
  if (w->system->dims.nt == 2 && with_friction(w, island) && has_motors_alone(w, island)) return 0;
  return count_rows(l, w, island) <= NSDAE_DENSE_ONE &&
         nsdae_members_count(&w->islands->row, island) <= NSDAE_DENSE_JOINTED &&
         nsdae_island_size(w, island) <= NSDAE_DENSE_JOINTED;
}

int nsdae_dense_island_fits(const nsdae_dense_island *l, const nsdae_island_equations *w,
                            int island)
{
  const nsdae_contact_islands *is = w->islands;
  int k = nsdae_members_count(&is->contact, island);
  int nt = w->system->dims.nt, one = is->blocks == 1, closed = w->with_contacts ? k : 0;
  int rows = closed * (nt == 1 ? 3 : 1);
  if (nsdae_members_count(&is->joint, island) > 0) return fits_joints(l, w, island);
  if (nt == 2 && closed > 0 && with_friction(w, island))
    return nsdae_contacts_polygons(&l->contacts);
  if (rows > (one ? NSDAE_DENSE_ONE : NSDAE_DENSE_ROWS)) return 0;
  if (one) return 1;
  int m = nsdae_members_count(&is->row, island);
  if (k > 0 && m > 0)
    return m <= NSDAE_DENSE_JOINTED && nsdae_island_size(w, island) <= NSDAE_DENSE_JOINTED;
  return m <= NSDAE_DENSE_M && nsdae_island_size(w, island) <= NSDAE_DENSE_V;
}

int nsdae_dense_island_fits_all(const nsdae_dense_island *l)
{
  const nsdae_system *s = l->contacts.system;
  if (nsdae_terms_most(s) == NSDAE_ANY_NUMBER || s->blocks.count > 1 ||
      (s->tracked && s->dims.nt == 2))
    return 0;
  if (l->contacts.slides.count > 0 || nsdae_contacts_polygons(&l->contacts)) return 1;
  for (int i = 0; i < s->dims.k && s->dims.nt == 2; i++)
    if (s->contact[i].mu > 0) return 0;
  return s->dims.k * (s->dims.nt == 1 ? 3 : 1) <= NSDAE_DENSE_ONE;
}

/* ---- the island at hand */

static int gather_blocks(nsdae_gathered *g, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->block;
  const nsdae_blocks *blocks = &w->system->blocks;
  const int *block = members->of + members->first[island];
  int n = 0;
  size_t square = 0;
  g->blocks.count = nsdae_members_count(members, island);
  for (int i = 0; i < g->blocks.count; i++) {
    size_t size = (size_t)nsdae_blocks_size(blocks, block[i]);
    g->start[block[i]] = g->blocks.first[i] = n;
    g->blocks.square[i] = square;
    if (g->blocks.count > 1)
      memcpy(g->M + square, w->M + blocks->square[block[i]], size * size * sizeof *g->M);
    n += (int)size;
    square += size * size;
  }
  g->blocks.first[g->blocks.count] = n;
  g->blocks.square[g->blocks.count] = square;
  return n;
}

/* The number in the island of the block whose velocities start there. */
static int block_at(const nsdae_blocks *blocks, int start)
{
  int low = 0, high = blocks->count;
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (blocks->first[middle] <= start)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static int gather_rows(nsdae_gathered *g, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->row;
  const nsdae_rows *J = &w->terms->by.jacobian;
  int m = nsdae_members_count(members, island), part = 0;
  g->J.count = m;
  g->J.stride = J->stride;
  g->J.value = J->value;
  g->J.first[0] = 0;
  for (int i = 0; i < m; i++) {
    int row = members->of[members->first[island] + i];
    for (int p = J->first[row]; p < J->first[row + 1]; p++) {
      g->J.block[part] = block_at(&g->blocks, g->start[J->block[p]]);
      g->J.at[part++] = J->at[p];
    }
    g->J.first[i + 1] = part;
  }
  return m;
}

static void gather_right_hand_side(nsdae_gathered *g, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  const nsdae_blocks *blocks = &w->system->blocks;
  for (int i = 0; i < g->blocks.count; i++) {
    int b = is->block.of[is->block.first[island] + i];
    memcpy(g->r + g->blocks.first[i], w->r + blocks->first[b],
           (size_t)nsdae_blocks_size(blocks, b) * sizeof *g->r);
  }
  for (int i = 0; i < g->J.count; i++)
    g->lambda[i] = w->lambda[is->row.of[is->row.first[island] + i]];
}

static int factor(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_factorisation *f = w->factorisation;
  nsdae_kkt *kkt = &l->kkt;
  const int *row = w->islands->row.of + w->islands->row.first[island];
  int *held = kkt->dense.pivoted.held;
  kkt->spare = nsdae_factorisation_spare(f, kkt->m, row);
  for (int i = 0; kkt->spare > 0 && !kkt->is_sparse && i < kkt->m; i++) held[i] = f->held[row[i]];
  int status = nsdae_kkt_factor(kkt, l->at.M, l->at.J);
  if (status < 0 || (kkt->rank == kkt->m && !f->dropped)) return status;
  for (int i = 0; i < kkt->m; i++)
    f->held[row[i]] = kkt->rank == kkt->m ||
                      (kkt->is_sparse ? !nsdae_sparse_kkt_is_dropped(&kkt->sparse, i) : held[i]);
  return status;
}

/* Its blocks and rows, factored. */
static int take(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_system *s = w->system;
  nsdae_gathered *g = &l->gathered;
  const nsdae_rows *J = &w->terms->by.jacobian;
  nsdae_contacts *c = &l->contacts;
  int whole = nsdae_members_count(&w->islands->block, island) == s->blocks.count;
  int same = l->factored == w->factorisation->number && l->island == island;
  if (whole)
    l->at = (nsdae_island_view){&s->blocks, J, w->M, w->r, w->v, w->size, w->lambda, 1};
  else
    l->at = (nsdae_island_view){&g->blocks, &g->J, g->M, g->r, g->v, g->size, g->lambda, 0};
  int n = s->dims.nv, m = s->dims.m, status = NSDAE_OK;
  if (!whole && !same) {
    n = gather_blocks(g, w, island);
    m = gather_rows(g, w, island);
  }
  if (!whole && g->blocks.count == 1)
    l->at.M = w->M + s->blocks.square[w->islands->block.of[w->islands->block.first[island]]];
  if (!same) {
    l->factored = -1;
    nsdae_kkt_turn_to(&l->kkt, l->at.blocks, n, m);
    status = factor(l, w, island);
  }
  if (status < 0) return status;
  l->factored = w->factorisation->number;
  l->island = island;
  c->part.J = l->at.J;
  c->part.m = l->kkt.m;
  c->part.place = whole ? s->blocks.first : g->start;
  if (!whole) gather_right_hand_side(g, w, island);
  return NSDAE_OK;
}

/* Frictional joints of the island, with their rows of Phi_q in it. */
static void take_joints(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  nsdae_contact_slides *s = &l->contacts.slides;
  const int *row = is->row.of + is->row.first[island];
  s->count = nsdae_members_count(&is->joint, island);
  for (int i = 0; i < s->count; i++) {
    s->place[i] = is->joint.of[is->joint.first[island] + i];
    s->number[i] = is->joint_number[s->place[i]];
    s->constraint[i] = 0;
    const nsdae_frictional_joint *joint = &w->system->frictional_joint[s->number[i]];
    while (joint->mu > 0 && row[s->constraint[i]] != joint->constraint) s->constraint[i]++;
  }
}

static void close_contacts(nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_members *members = &w->islands->contact;
  nsdae_contacts *c = &l->contacts;
  if (l->at.whole && l->closed == w->factorisation->closed) return;
  l->closed = l->at.whole ? w->factorisation->closed : -1;
  c->part.coefficient = w->law;
  c->part.id = w->id;
  c->warm = w->warm;
  c->slides.bound = w->joint_bound;
  c->slides.beside = w->beside;
  take_joints(l, w, island);
  nsdae_contacts_close_these(c, nsdae_members_count(members, island),
                             members->of + members->first[island], w->results);
}

/* ---- an island at rest */

/* Whether something drives the island: a velocity is asked of a row, a contact or a joint. */
static int driven(const nsdae_dense_island *l, const nsdae_island_equations *w)
{
  const nsdae_contacts *c = &l->contacts;
  const nsdae_terms *T = w->terms;
  int nt = w->system->dims.nt, any = nsdae_largest(l->kkt.m, l->asked) > 0;
  for (int a = 0; a < c->active_count && !any; a++)
    any = T->w_N[c->active[a]] != 0 || nsdae_largest(nt, T->w_T + c->active[a] * nt) > 0;
  for (int i = 0; i < c->slides.count && !any; i++)
    any =
        T->frictional_joint.w[c->slides.number[i]] != 0 || nsdae_slides_beside(c, i).compliance > 0;
  return any;
}

/* Whether no entry moves a contact by more than the digits of the solution, in parts of the largest
 * velocity of a contact without impulses; each as if by the largest lever. One that moves none, as
 * of a body apart from all contacts, is held against its own terms. */
static int stands(const nsdae_dense_island *l)
{
  const nsdae_contacts *c = &l->contacts;
  const double *W = c->delassus.W, digits = fmin(c->lcp.options.tol, NSDAE_STILL);
  double speed = nsdae_largest(c->columns, c->delassus.offset);
  for (int j = 0; j < l->kkt.n; j++) /* mostly the first */
    if (!(fabs(l->at.v[j]) <= digits * speed)) return 0;
  double fastest = nsdae_largest(l->kkt.n, l->at.v), most = 0;
  if (fastest == 0) return 0; /* without more ado */
  for (int j = 0; j < l->kkt.n; j++) {
    double lever = 0;
    for (int i = 0; i < c->columns; i++) lever = fmax(lever, fabs(W[i * l->kkt.n + j]));
    if (lever == 0 && fabs(l->at.v[j]) > digits * l->at.size[j]) return 0;
    most = fmax(most, lever);
  }
  return fastest * most <= digits * speed;
}

/* Exactly: it does not creep. */
static void stand(nsdae_dense_island *l)
{
  const nsdae_contacts *c = &l->contacts;
  int nt = c->system->dims.nt;
  memset(l->at.v, 0, (size_t)l->kkt.n * sizeof *l->at.v);
  for (int a = 0; a < c->active_count; a++) {
    c->results->after[c->active[a]] = 0;
    for (int j = 0; j < nt; j++) c->results->after_t[c->active[a] * nt + j] = 0;
  }
  for (int i = 0; i < c->slides.count; i++) c->results->slide_after[c->slides.number[i]] = 0;
}

/* ---- solution */

static void scatter(const nsdae_dense_island *l, const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  const nsdae_blocks *blocks = &w->system->blocks;
  for (int i = 0; i < l->at.blocks->count; i++) {
    int b = is->block.of[is->block.first[island] + i], from = l->at.blocks->first[i];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof *w->v;
    memcpy(w->v + blocks->first[b], l->at.v + from, bytes);
    memcpy(w->size + blocks->first[b], l->at.size + from, bytes);
  }
  for (int i = 0; i < l->kkt.m; i++)
    w->lambda[is->row.of[is->row.first[island] + i]] = l->at.lambda[i];
}

static int solve_alone(nsdae_dense_island *l)
{
  const nsdae_island_view *at = &l->at;
  int n = l->kkt.n;
  for (int j = 0; j < n; j++) at->v[j] = at->r[j];
  int status = nsdae_kkt_solve(&l->kkt, 1, at->v, n, at->lambda, l->kkt.m);
  for (int j = 0; j < n; j++) at->size[j] = at->v[j];
  return status;
}

/* v, lambda, the impulses and the residuals of the laws, from the bases in memory. */
static int solve(nsdae_dense_island *l, const nsdae_island_equations *w,
                 nsdae_natural_residual *residual)
{
  const nsdae_island_view *at = &l->at;
  int status =
      nsdae_contacts_step(&l->contacts, w->terms, &l->kkt, at->r, at->v, at->size, at->lambda);
  if (status < 0) return status;
  if (stands(l) && !driven(l, w)) stand(l);
  *residual = nsdae_dense_residual(l, 0);
  if (!(nsdae_natural_residual_scaled(residual) <= l->contacts.lcp.options.tol))
    *residual = nsdae_dense_residual(l, 1);
  return status;
}

static int solve_again(nsdae_dense_island *l, const nsdae_island_equations *w,
                       nsdae_natural_residual *residual)
{
  memcpy(l->at.lambda, l->asked, (size_t)l->kkt.m * sizeof *l->asked);
  return solve(l, w, residual);
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

/* Bases of the contacts and joints, from or to their places. */
static void copy_bases(nsdae_dense_island *l, int back)
{
  const nsdae_contacts *c = &l->contacts;
  int *basis = l->basis;
  int rows = c->rows_most;
  for (int a = 0; a < c->active_count; a++, basis += rows) {
    int *of = c->warm.basis + (size_t)c->active[a] * (size_t)rows;
    memcpy(back ? of : basis, back ? basis : of, (size_t)rows * sizeof *of);
  }
  for (int i = 0; i < c->slides.count; i++, basis += 3) {
    int *of = c->warm.slide_basis + 3 * (size_t)c->slides.place[i];
    memcpy(back ? of : basis, back ? basis : of, 3 * sizeof *of);
  }
}

/* The complementarity problem is judged by scales of its own: if it is solved and a law is not,
 * once more and by two digits more. If that fails, or finds another solution of which a law is not
 * solved either, the first one is taken. */
static int solve_laws(nsdae_dense_island *l, const nsdae_island_equations *w,
                      nsdae_natural_residual *residual)
{
  nsdae_contacts *c = &l->contacts;
  double *tol = &c->lcp.options.tol, asked = *tol, accept = c->lcp.accept;
  memcpy(l->asked, l->at.lambda, (size_t)l->kkt.m * sizeof *l->asked);
  copy_bases(l, 0);
  int status = solve(l, w, residual);
  if (status < 0 || c->lcp.accepted || nsdae_natural_residual_scaled(residual) <= asked)
    return status;
  for (int a = 0; a < c->active_count; a++) l->was[a] = c->results->normal[c->active[a]];
  *tol = 1e-2 * asked;
  c->lcp.accept = 0;
  status = solve_again(l, w, residual);
  *tol = asked;
  c->lcp.accept = accept;
  if (status == NSDAE_OK &&
      (same_impulses(l, l->was) || nsdae_natural_residual_scaled(residual) <= asked))
    return status;
  copy_bases(l, 1);
  return solve_again(l, w, residual);
}

int nsdae_dense_island_solve(nsdae_dense_island *l, const nsdae_island_equations *w, int island,
                             int least_norm, nsdae_natural_residual *residual)
{
  l->solves = 0;
  if (!enough(l, w, island)) return NSDAE_ARRAYS_GROW;
  int status = take(l, w, island);
  if (status == NSDAE_OK && l->kkt.rank < l->kkt.m && !least_norm) status = NSDAE_E_RANK;
  if (status < 0) return status;
  l->solves = w->with_contacts && nsdae_members_count(&w->islands->contact, island) +
                                          nsdae_members_count(&w->islands->joint, island) >
                                      0;
  if (l->solves) close_contacts(l, w, island);
  status = l->solves ? solve_laws(l, w, residual) : solve_alone(l);
  if (status == NSDAE_OK && !l->at.whole) scatter(l, w, island);
  return status;
}

int nsdae_dense_island_solve_mass(const nsdae_dense_island *l, long factorisation, double *r)
{
  if (l->factored != factorisation || !l->at.whole) return 0;
  nsdae_kkt_solve_mass(&l->kkt, r);
  return 1;
}
