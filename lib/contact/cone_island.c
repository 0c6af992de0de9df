#include "cone_island.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "errors.h"
#include "arena.h"
#include "listed.h"
#include "slides.h"
#include "friction_solver.h"
#include "vector.h"

/* Newton steps after the solution of islands with few contacts, and of those without impulses of a
 * step before, to rounding: bodies that stick there, or are placed at rest, do not creep. */
enum { FEW = 16, REFINE = 4 };

/* Where a joint is: at its limit in either direction, within it; or a planar contact. */
enum motor_set { AT_LOW = -1, WITHIN, AT_HIGH, PLANAR };
enum { MOTOR_ROUNDS = 10 };

void nsdae_cone_island_layout(nsdae_cone_island *c, const nsdae_system *system, nsdae_arena *arena)
{
  const nsdae_blocks *blocks = &system->blocks;
  nsdae_arena_ints(arena, blocks->count, (int **[]){&c->number, &c->at.member, &c->at.size, NULL});
  c->set = NSDAE_ARENA_INTS(arena, system->dims.f);
  c->at.M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  nsdae_arena_doubles(arena, system->dims.nv, (double **[]){&c->at.f, &c->lever, NULL});
}

/* By item, of which there is room for one more; the last two are by entry and by value. */
enum { ARRAYS = 11 };

static void list_arrays(nsdae_cone_arrays *at, int columns, nsdae_array all[ARRAYS])
{
  const nsdae_array list[ARRAYS] = {
      NSDAE_ARRAY(at->item, 1),        NSDAE_ARRAY(at->rows, 1),
      NSDAE_ARRAY(at->mu, 1),          NSDAE_ARRAY(at->w, columns),
      NSDAE_ARRAY(at->r, columns),     NSDAE_ARRAY(at->u, columns),
      NSDAE_ARRAY(at->guess, columns), NSDAE_ARRAY(at->compliance, columns),
      NSDAE_ARRAY(at->first, 1),       NSDAE_ARRAY(at->block, 1),
      NSDAE_ARRAY(at->value, 1)};
  memcpy(all, list, sizeof list);
}

int nsdae_cone_island_grow(nsdae_cone_island *c, const nsdae_system *system,
                           const nsdae_room *contacts, const nsdae_room *rows)
{
  nsdae_array all[ARRAYS];
  const nsdae_dims *d = &system->dims;
  size_t items = contacts->entries + (size_t)d->m + (size_t)d->f,
         entries = (size_t)nsdae_terms_parts(system) * contacts->entries + rows->entries;
  list_arrays(&c->at, d->f > 0 && d->nt == 0 ? 2 : 1 + d->nt, all);
  int status = nsdae_arrays_grow(all, ARRAYS - 2, items + 1);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(all + ARRAYS - 2, 1, entries);
  if (status == NSDAE_OK)
    status = nsdae_arrays_grow(all + ARRAYS - 1, 1, contacts->values + rows->values);
  return status;
}

void nsdae_cone_island_release(nsdae_cone_island *c)
{
  nsdae_array all[ARRAYS];
  list_arrays(&c->at, 1, all);
  nsdae_arrays_release(all, ARRAYS);
}

/* ---- gathering */

static void set_problem(nsdae_cone_island *c, int contacts, int bilateral)
{
  const nsdae_cone_arrays *at = &c->at;
  c->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_GLOBAL,
                                        .contacts = contacts,
                                        .bilateral = bilateral,
                                        .rows = at->rows,
                                        .mu = at->mu,
                                        .w = at->w,
                                        .size = at->size,
                                        .M = at->M,
                                        .f = at->f,
                                        .first = at->first,
                                        .block = at->block,
                                        .value = at->value};
}

static void add_blocks(nsdae_cone_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_members *members = &w->islands->block;
  double *M = c->at.M, *f = c->at.f;
  c->problem.blocks = nsdae_members_count(members, island);
  for (int i = 0; i < c->problem.blocks; i++) {
    int b = members->of[members->first[island] + i], n = nsdae_blocks_size(blocks, b);
    size_t square = (size_t)n * (size_t)n;
    c->number[b] = i;
    c->at.member[i] = b;
    c->at.size[i] = n;
    memcpy(M, w->M + blocks->square[b], square * sizeof *M);
    memcpy(f, w->r + blocks->first[b], (size_t)n * sizeof *f);
    M += square;
    f += n;
  }
}

/* A direction of an item: a row by blocks. */
typedef struct direction {
  const nsdae_rows *rows;
  int i;
} direction;

/* The least number above last of a block that the item touches; -1: none. */
static int next_number(const nsdae_cone_island *c, const direction *d, int count, int last)
{
  int next = -1;
  for (const direction *end = d + count; d < end; d++)
    for (int p = d->rows->first[d->i]; p < d->rows->first[d->i + 1]; p++) {
      int number = c->number[d->rows->block[p]];
      if (number > last && (next < 0 || number < next)) next = number;
    }
  return next;
}

/* Its part on block b, of n velocities, to value; returns the end of it. */
static double *copy_part(const direction *d, int b, int n, double *value)
{
  const nsdae_rows *rows = d->rows;
  int p = rows->first[d->i], end = rows->first[d->i + 1];
  while (p < end && rows->block[p] != b) p++;
  const double *from = p < end ? rows->value + rows->at[p] : NULL;
  for (int j = 0; j < n; j++) *value++ = from ? from[(size_t)j * rows->stride] : 0;
  return value;
}

/* An item, number i in the whole, with its directions, which are one behind the other in each
 * entry. Its entries in the order of their blocks, as files have them: sums then round alike.
 * Returns the end of value. */
static double *add_item(nsdae_cone_island *c, const nsdae_island_equations *w, const direction *d,
                        int columns, int differing, int i, double *value)
{
  int entry = c->at.first[c->items];
  for (int at = next_number(c, d, differing, -1); at >= 0; at = next_number(c, d, differing, at)) {
    int b = c->at.member[at], n = nsdae_blocks_size(&w->system->blocks, b);
    c->at.block[entry++] = at;
    for (int l = 0; l < columns; l++) value = copy_part(&d[l], b, n, value);
  }
  c->at.item[c->items++] = i;
  c->at.first[c->items] = entry;
  for (int l = 0; l < columns; l++) c->at.compliance[c->m++] = 0;
  return value;
}

static double *add_contact(nsdae_cone_island *c, const nsdae_island_equations *w, int a,
                           double *value)
{
  const nsdae_coefficients *law = &w->law[a];
  const nsdae_terms *T = w->terms;
  const nsdae_impulses *r = w->results;
  int nt = w->system->dims.nt, columns = law->mu > 0 ? 1 + nt : 1;
  direction along[3] = {{&T->by.normal, a}};
  c->at.rows[c->items] = columns;
  c->at.mu[c->items] = law->mu;
  c->at.w[c->m] = T->w_N[a] + law->e_n * r->before[a];
  c->at.r[c->m] = r->normal[a];
  c->driven |= T->w_N[a] != 0;
  for (int d = 1; d < columns; d++) {
    int j = a * nt + d - 1;
    along[d].rows = &T->by.tangent;
    along[d].i = j;
    c->at.w[c->m + d] = T->w_T[j] + law->e_t * r->before_t[j];
    c->at.r[c->m + d] = r->tangential[j];
    c->driven |= T->w_T[j] != 0;
  }
  return add_item(c, w, along, columns, nsdae_fewer(columns, nsdae_terms_differing(w->system)), a,
                  value);
}

/* A motor within its limit: its row alone. Else a planar contact, whose normal row is no row of any
 * block; the limit: at most this many times the impulse that stops the fastest item, see slides.h.
 */
static double *add_joint(nsdae_cone_island *c, const nsdae_island_equations *w, int j, double times,
                         double *value)
{
  static int none[2];
  static const nsdae_rows no_row = {.count = 1, .first = none};
  const nsdae_terms *T = w->terms;
  const direction along[2] = {{&no_row, 0}, {&T->by.frictional_joint, j}};
  const nsdae_joint_row *beside = &w->beside[j];
  const double s = beside->scale;
  int planar = c->set[j] == PLANAR, row = c->m + planar;
  double *from = value, d = 0;
  if (planar) {
    d = s * s * nsdae_terms_mobility(T, w->M, &T->by.frictional_joint, j) + beside->compliance;
    double limit = nsdae_slides_limit(w->joint_bound[j] / s, times * c->fastest / d);
    d = nsdae_slides_normal(d, limit, c->fastest);
    c->at.rows[c->items] = 2;
    c->at.mu[c->items] = 1;
    c->at.w[row - 1] = -d * limit;
    c->at.r[row - 1] = limit;
  }
  c->at.w[row] = s * T->frictional_joint.w[j] + beside->shift;
  c->at.r[row] = w->results->frictional_joint_impulse[j] / s;
  c->driven |= T->frictional_joint.w[j] != 0 || beside->compliance > 0;
  value = add_item(c, w, along + !planar, 1 + planar, 1 + planar, j, value);
  while (from < value) *from++ *= s;
  if (planar) c->at.compliance[row - 1] = d;
  c->at.compliance[row] = beside->compliance;
  return value;
}

/* f += W_j times the impulse. */
static void push(nsdae_cone_island *c, const nsdae_island_equations *w, int j, double impulse)
{
  const nsdae_rows *rows = &w->terms->by.frictional_joint;
  for (int p = rows->first[j]; p < rows->first[j + 1]; p++) {
    const double *W = rows->value + rows->at[p];
    double *f = c->at.f;
    int number = c->number[rows->block[p]];
    for (int i = 0; i < number; i++) f += c->at.size[i];
    for (int l = 0; l < c->at.size[number]; l++) f[l] += impulse * W[(size_t)l * rows->stride];
  }
}

/* The number of the i-th of the joints of all islands. */
static int joint_at(const nsdae_island_equations *w, int i)
{
  return w->islands->joint_number[w->islands->joint.of[i]];
}

static double *add_row(nsdae_cone_island *c, const nsdae_island_equations *w, int row,
                       double *value)
{
  const direction along = {&w->terms->by.jacobian, row};
  c->at.w[c->m] = -w->lambda[row];
  c->driven |= w->lambda[row] != 0;
  c->at.r[c->m] = 0;
  return add_item(c, w, &along, 1, 1, row, value);
}

static void gather(nsdae_cone_island *c, const nsdae_island_equations *w, int island, double times)
{
  const nsdae_members *contact = &w->islands->contact, *joint = &w->islands->joint,
                      *row = &w->islands->row;
  double *value = c->at.value;
  c->items = c->m = c->driven = c->motors = 0;
  c->at.first[0] = 0;
  c->contacts = nsdae_members_count(contact, island);
  set_problem(c, 0, 0);
  if (nsdae_members_count(joint, island) > 0) c->problem.compliance = c->at.compliance;
  add_blocks(c, w, island);
  for (int i = contact->first[island]; i < contact->first[island + 1]; i++)
    value = add_contact(c, w, contact->of[i], value);
  for (int i = joint->first[island]; i < joint->first[island + 1]; i++)
    if (c->set[joint_at(w, i)] == PLANAR) value = add_joint(c, w, joint_at(w, i), times, value);
  c->problem.contacts = c->items;
  for (int i = row->first[island]; i < row->first[island + 1]; i++)
    value = add_row(c, w, row->of[i], value);
  for (int i = joint->first[island]; i < joint->first[island + 1]; i++) {
    int j = joint_at(w, i), set = c->set[j];
    if (set == AT_LOW || set == AT_HIGH) push(c, w, j, set * w->joint_bound[j]);
    if (set != WITHIN) continue;
    value = add_joint(c, w, j, times, value);
    c->motors++;
  }
  c->problem.bilateral = c->items - c->problem.contacts;
}

int nsdae_cone_island_reserve(nsdae_cone_island *c, const nsdae_system *system,
                              nsdae_friction_solver *solver)
{
  const nsdae_dims *d = &system->dims;
  const nsdae_cone_arrays *at = &c->at;
  int n = d->nv, columns = d->m;
  set_problem(c, d->k, d->m);
  c->problem.blocks = 1;
  for (int i = 0; i < d->k; i++) {
    at->mu[i] = system->contact[i].mu;
    at->rows[i] = at->mu[i] > 0 ? 1 + d->nt : 1;
    columns += at->rows[i];
  }
  at->size[0] = n;
  memset(at->M, 0, (size_t)n * (size_t)n * sizeof *at->M);
  for (int j = 0; j < n; j++) at->M[j * (n + 1)] = 1;
  memset(at->f, 0, (size_t)n * sizeof *at->f);
  memset(at->w, 0, (size_t)columns * sizeof *at->w);
  for (int i = 0; i <= d->k + d->m; i++) at->first[i] = i;
  for (int i = 0; i < d->k + d->m; i++) at->block[i] = 0;
  for (size_t i = 0; i < (size_t)columns * (size_t)n; i++) at->value[i] = 1;
  return nsdae_fc_reserve(solver, &c->problem);
}

/* ---- solving */

static int unsolved(const nsdae_cone_island *c, const nsdae_island_equations *w, int status,
                    const nsdae_cone_work *work)
{
  char first[NSDAE_CALLED_SIZE] = "none";
  if (c->contacts > 0) nsdae_island_called(w, c->at.item[0], first);
  nsdae_error_set(
      work->error, status, "nsdae_contacts", "",
      "contact problem of %d contacts (first %s) and %d constraints at t = %g: "
      "%s, residual %.3g above %.3g; a smaller dt, less friction or more contact_work may help",
      c->contacts, first, c->problem.bilateral, nsdae_terms_time(w->terms),
      nsdae_status_message(status), work->info.residual, work->tol);
  return nsdae_error_at(work->error, status, -1, nsdae_terms_time(w->terms));
}

/* Of contact i of the problem, whose velocities after are known. */
static int mode_of(const nsdae_cone_island *c, const nsdae_island_equations *w, int i, int row)
{
  const nsdae_impulses *r = w->results;
  int a = c->at.item[i], nt = w->system->dims.nt;
  double square = 0;
  if (!(c->at.r[row] > 0)) return NSDAE_MODE_OPEN;
  for (int j = a * nt; j < (a + 1) * nt; j++) {
    double slip = r->after_t[j] + w->law[a].e_t * r->before_t[j];
    square += slip * slip;
  }
  return c->at.rows[i] > 1 && !(sqrt(square) > c->slow) ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
}

static void scatter(const nsdae_cone_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_members *joint = &w->islands->joint;
  nsdae_impulses *to = w->results;
  int nt = w->system->dims.nt, row = 0;
  for (int i = 0; i < c->contacts; row += c->at.rows[i++]) {
    int a = c->at.item[i];
    to->normal[a] = c->at.r[row];
    nsdae_terms_contact_rates(w->terms, a, w->v, to->after, to->after_t);
    for (int d = 1; d <= nt; d++)
      to->tangential[a * nt + d - 1] = d < c->at.rows[i] ? c->at.r[row + d] : 0;
    to->mode[a] = mode_of(c, w, i, row);
  }
  for (int i = c->contacts; i < c->problem.contacts; i++, row += 2) {
    int j = c->at.item[i];
    const nsdae_joint_row *beside = &w->beside[j];
    double limit = c->at.r[row], impulse = fmax(-limit, fmin(limit, c->at.r[row + 1]));
    to->slide_after[j] = nsdae_terms_slide_rate(w->terms, j, w->v);
    to->frictional_joint_impulse[j] = impulse * beside->scale;
    double slip = beside->scale * to->slide_after[j] + beside->compliance * impulse + beside->shift;
    to->frictional_joint_mode[j] = fabs(slip) > c->slow ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
  }
  for (int i = joint->first[island]; i < joint->first[island + 1]; i++) {
    int j = joint_at(w, i);
    if (c->set[j] == PLANAR) continue;
    to->frictional_joint_mode[j] = c->set[j] == WITHIN ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
    to->slide_after[j] = nsdae_terms_slide_rate(w->terms, j, w->v);
  }
  for (int i = c->problem.contacts; i < c->items - c->motors; i++)
    w->lambda[c->at.item[i]] = -c->at.r[row++];
}

int nsdae_cone_solve_to(nsdae_cone_island *c, nsdae_cone_work *work, double tol, double budget)
{
  const nsdae_friction_info before = work->info;
  c->options.tol = tol;
  c->options.budget = budget;
  memcpy(c->at.guess, c->at.r, (size_t)c->m * sizeof *c->at.guess);
  int status = nsdae_friction_solver_solve(work->solver, &c->problem, &c->options, c->at.r, c->at.u,
                                           &work->info);
  work->info.sweeps += before.sweeps;
  work->info.iterations += before.iterations;
  return status;
}

/* To the tolerances of accuracy.h in turn, then to the residual that is accepted instead. */
static int solve(nsdae_cone_island *c, const nsdae_island_equations *w, int island,
                 nsdae_cone_work *work)
{
  const nsdae_accuracy *a = work->accuracy;
  int status = NSDAE_E_LCP, size = c->contacts + nsdae_members_count(&w->islands->joint, island);
  nsdae_aim aim = {0, 0};
  work->info = (nsdae_friction_info){0};
  while (status == NSDAE_E_LCP && (aim = nsdae_accuracy_aim(a, size, aim.tol)).tol > 0) {
    work->tol = aim.tol;
    status = nsdae_cone_solve_to(c, work, aim.tol, aim.budget);
  }
  const double accept = nsdae_accuracy_accept(a, work->tol),
               budget = nsdae_accuracy_budget(a, work->tol, size);
  if (status == NSDAE_E_LCP && budget > 0 && work->info.residual > accept)
    status =
        nsdae_cone_solve_to(c, work, fmax(accept, work->tol), (1 - NSDAE_SHARE_TO_TOL) * budget);
  if (status == NSDAE_OK && work->info.residual <= work->tol)
    status = nsdae_cone_prefer_rest(c, w, work, budget);
  if (status == NSDAE_OK && work->info.residual <= work->tol)
    status = nsdae_cone_solve_rest(c, w, work, budget);
  return status == NSDAE_E_LCP && work->info.residual <= accept ? NSDAE_OK : status;
}

/* The row along which item i moves, and the velocity that is asked of it beside. */
static direction row_of(const nsdae_cone_island *c, const nsdae_island_equations *w, int i,
                        double *asked, double *scale)
{
  const nsdae_terms *T = w->terms;
  int a = c->at.item[i],
      joint = i >= c->contacts && (i < c->problem.contacts || i >= c->items - c->motors);
  *scale = joint ? w->beside[a].scale : 1;
  *asked = i < c->contacts ? T->w_N[a]
           : joint         ? T->frictional_joint.w[a] + w->beside[a].shift / *scale
                           : T->constraint.phi_t[a];
  return (direction){i < c->contacts ? &T->by.normal
                     : joint         ? &T->by.frictional_joint
                                     : &T->by.jacobian,
                     a};
}

/* Of v = M^-1 r without impulses: the largest velocity of an item, and 32 roundings of its terms.
 */
static int find_speeds(nsdae_cone_island *c, const nsdae_island_equations *w,
                       const nsdae_cone_work *work, double *fastest, double *rounding)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_terms *T = w->terms;
  int nt = w->system->dims.nt;
  double size = 0;
  *fastest = 0;
  nsdae_cone_begin_velocities(c, w);
  int status = nsdae_cone_solve_masses(c, w, work->L);
  for (int i = 0; i < c->problem.blocks; i++)
    for (int b = c->at.member[i], j = blocks->first[b]; j < blocks->first[b + 1]; j++)
      w->size[j] = fabs(w->v[j]);
  for (int i = 0; i < c->items && status == NSDAE_OK; i++) {
    double asked, scale;
    const direction d = row_of(c, w, i, &asked, &scale);
    *fastest = fmax(*fastest, scale * fabs(nsdae_rows_add_dot(blocks, d.rows, d.i, w->v, asked)));
    size = fmax(size, scale * (fabs(asked) + nsdae_rows_dot_sizes(blocks, d.rows, d.i, w->size)));
    for (int j = d.i * nt; i < c->contacts && j < d.i * nt + c->at.rows[i] - 1; j++)
      size = fmax(size, fabs(T->w_T[j]) + nsdae_rows_dot_sizes(blocks, &T->by.tangent, j, w->size));
  }
  *rounding = 32 * DBL_EPSILON * size;
  return status;
}

/* c->fastest. Not below what leaves the rounding within the tolerance: where a motor has its speed,
 * a rate is rounding. */
static int find_fastest(nsdae_cone_island *c, const nsdae_island_equations *w,
                        const nsdae_cone_work *work)
{
  double fastest, rounding;
  int status = find_speeds(c, w, work, &fastest, &rounding);
  c->fastest = fmax(fastest, rounding / work->tol);
  return status;
}

/* The residual without the rounding of W^T v, as in dense_residual.c: in a step of length h, in
 * which impulses are of the order h, velocities v have no more digits than eps v. A contact_tol
 * below these roundings is one that no step meets. Returns the status of the solution by this
 * residual. */
static int leave_rounding(nsdae_cone_island *c, const nsdae_island_equations *w,
                          nsdae_cone_work *work, int status)
{
  double fastest, rounding;
  if ((status < 0 && status != NSDAE_E_LCP) || work->info.residual <= work->tol ||
      work->tol < 32 * DBL_EPSILON)
    return status;
  if (find_speeds(c, w, work, &fastest, &rounding) < 0) return status;
  double left = fmax(0, work->info.residual - rounding / nsdae_fc_speed(work->solver));
  if (left <= work->tol) work->info.residual = left;
  return left <= work->tol ? NSDAE_OK : status;
}

/* Whether an impulse is at a limit that is less than its bound. */
static int reaches_limit(const nsdae_cone_island *c, const nsdae_island_equations *w)
{
  for (int i = 0, row = 0; i < c->problem.contacts; row += c->at.rows[i++])
    if (i >= c->contacts &&
        c->at.r[row] * w->beside[c->at.item[i]].scale <
            NSDAE_AT_BOUND * w->joint_bound[c->at.item[i]] &&
        fabs(c->at.r[row + 1]) > NSDAE_AT_BOUND * c->at.r[row])
      return 1;
  return 0;
}

/* A first guess of the sets from the step before. Returns the number of motors. */
static int begin_sets(nsdae_cone_island *c, const nsdae_island_equations *w, int island)
{
  const nsdae_members *joint = &w->islands->joint;
  int motors = 0;
  for (int i = joint->first[island]; i < joint->first[island + 1]; i++) {
    int j = joint_at(w, i);
    int motor = w->system->frictional_joint[j].position != NSDAE_NO_POSITION;
    double was = w->results->frictional_joint_impulse[j];
    int at = fabs(was) >= NSDAE_AT_BOUND * w->joint_bound[j];
    c->set[j] = !motor ? PLANAR : !at ? WITHIN : was < 0 ? AT_LOW : AT_HIGH;
    motors += motor;
  }
  return motors;
}

/* Impulses of the motors after a solution, and whether their sets hold; all: to planar contacts. Of
 * one at its limit s b the row must not be s times a velocity above tol. Returns how many changed.
 */
static int change_sets(nsdae_cone_island *c, const nsdae_island_equations *w, int island, int all,
                       const nsdae_cone_work *work)
{
  const nsdae_members *joint = &w->islands->joint;
  const double slow = work->tol * nsdae_fc_speed(work->solver);
  double *impulse = w->results->frictional_joint_impulse;
  int changed = 0;
  for (int i = 1; i <= c->motors && !all; i++) {
    int j = c->at.item[c->items - i];
    impulse[j] = c->at.r[c->m - i] * w->beside[j].scale;
  }
  nsdae_cone_begin_velocities(c, w);
  nsdae_cone_add_impulses(c, w);
  if (nsdae_cone_solve_masses(c, w, work->L) < 0) return 0;
  for (int i = joint->first[island]; i < joint->first[island + 1]; i++) {
    int j = joint_at(w, i), set = c->set[j], to = set;
    const double bound = w->joint_bound[j];
    if (set == PLANAR) continue;
    if (set == WITHIN) {
      if (fabs(impulse[j]) > bound) to = impulse[j] < 0 ? AT_LOW : AT_HIGH;
    } else {
      impulse[j] = set * bound;
      double s = w->beside[j].scale,
             slip = s * nsdae_terms_slide_rate(w->terms, j, w->v) + w->beside[j].shift;
      if (set * slip + w->beside[j].compliance * bound / s > slow) to = WITHIN;
    }
    c->set[j] = all ? PLANAR : to;
    changed += c->set[j] != set;
  }
  return changed;
}

/* Of these sets, with the limits of the planar joints as in slides.h. */
static int solve_sets(nsdae_cone_island *c, const nsdae_island_equations *w, int island,
                      nsdae_cone_work *work)
{
  c->fastest = 0;
  gather(c, w, island, 0);
  const int planar = c->problem.contacts > c->contacts;
  int status = planar ? find_fastest(c, w, work) : NSDAE_OK;
  if (status < 0) return status;
  for (double times = NSDAE_BOUND_CONE;; times *= NSDAE_BOUND_FURTHER) {
    if (planar) gather(c, w, island, times);
    if (c->contacts <= FEW || nsdae_largest(c->m, c->at.r) == 0) c->options.refine = REFINE;
    status = solve(c, w, island, work);
    if (!planar || !reaches_limit(c, w)) return status;
  }
}

static int solve_motors(nsdae_cone_island *c, const nsdae_island_equations *w, int island,
                        nsdae_cone_work *work)
{
  int motors = begin_sets(c, w, island);
  for (int round = 1;; round++) {
    int status = solve_sets(c, w, island, work), all = status < 0 || round > MOTOR_ROUNDS;
    if (motors == 0 || change_sets(c, w, island, all, work) == 0) return status;
    if (all) motors = 0;
  }
}

int nsdae_cone_island_solve(nsdae_cone_island *c, const nsdae_island_equations *w, int island,
                            nsdae_cone_work *work)
{
  nsdae_friction_options_default(&c->options);
  work->tol = nsdae_accuracy_tol(work->accuracy);
  int status = leave_rounding(c, w, work, solve_motors(c, w, island, work));
  if (status < 0) return unsolved(c, w, status, work);
  const double speed = nsdae_fc_speed(work->solver), left = work->info.residual;
  work->residual = (nsdae_natural_residual){speed > 0 ? left * speed : left, speed, 0};
  status = nsdae_cone_velocities(c, w, work, speed);
  if (status == NSDAE_OK) scatter(c, w, island);
  return status;
}
