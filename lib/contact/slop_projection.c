#include "slop_projection.h"

#include <math.h>
#include <string.h>

#include "arena.h"

enum { PAIRS = 200 }; /* of sweeps, forwards and backwards */

/* Depth up to which a contact stays, relative to the slop. */
static const double deep = 1.1;

/* Share of what deep allows that a pair of sweeps may still change: they converge slowly. */
static const double CLOSE = 0.1;

/* A contact that comes out by its own velocity u in this number of steps is not moved: a bounce
 * would get height from it. After an impact at v a body is up to (1 + (1 - e) / 2) h v deep and u =
 * e v, so that it needs (3 - e) / (2 e) steps: 4 at e = 1/3. With a smaller e, bounces lose more
 * than the depth gives down to v = g h (3 - e) / (1 - e^2). Those of e v are then not higher than
 * (e v)^2 / 2 g = 0.5 g h^2 at e = 1/3, which is the slop: the ball comes to rest in it. */
static const double own_steps = 4;

enum { ARRAYS = 12 };

#define EACH(s)                                                                               \
  {                                                                                           \
    NSDAE_ARRAY((s)->missing, 1), NSDAE_ARRAY((s)->slop, 1), NSDAE_ARRAY((s)->weight, 1),     \
        NSDAE_ARRAY((s)->multiplier, 1), NSDAE_ARRAY((s)->gap, 1),                            \
        NSDAE_ARRAY((s)->end.closed, 1), NSDAE_ARRAY((s)->end.islands.contact.of, 1),         \
        NSDAE_ARRAY((s)->at, 1), NSDAE_ARRAY((s)->moved, 1), NSDAE_ARRAY((s)->end.number, 1), \
        NSDAE_ARRAY((s)->last.before, 1), NSDAE_ARRAY((s)->last.begun, 1)                     \
  }

void nsdae_slop_layout(nsdae_slop_projection *s, const nsdae_system *system, nsdae_arena *arena)
{
  s->by.free = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
  s->change = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
  s->factor.L = NSDAE_ARENA_DOUBLES(arena, nsdae_blocks_largest(&system->blocks));
  nsdae_contact_islands_layout(&s->end.islands, system, arena);
  s->end.stuck = NSDAE_ARENA_INTS(arena, system->dims.f);
}

/* Values of the rows of frictional joints, at most. */
static size_t joint_values(const nsdae_system *system)
{
  return (size_t)system->dims.f * (size_t)system->dims.nv;
}

int nsdae_slop_grow(nsdae_slop_projection *s, const nsdae_system *system,
                    const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_array each[ARRAYS] = EACH(s), values[] = {NSDAE_ARRAY(s->inverse, 1)};
  size_t m = (size_t)(system->dims.m + system->dims.f), of_rows = m * (size_t)system->dims.nv;
  nsdae_room all = nsdae_terms_room(system, contacts);
  if (system->call.constraint_rows) of_rows = rows->values + joint_values(system);
  int status = nsdae_arrays_grow(each, ARRAYS, all.entries + m);
  return status < 0 ? status : nsdae_arrays_grow(values, 1, all.values + of_rows);
}

void nsdae_slop_release(nsdae_slop_projection *s)
{
  const nsdae_array each[ARRAYS] = EACH(s), values[] = {NSDAE_ARRAY(s->inverse, 1)};
  nsdae_arrays_release(each, ARRAYS);
  nsdae_arrays_release(values, 1);
}

/* ---- rows of an island */

/* x := M_b^-1 x; 0 if M_b is not positive definite: the step factored M at another point. */
static void solve_block(nsdae_slop_projection *s, const nsdae_terms *T, int b, double *x)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int failed = s->factored != b ? nsdae_blocks_factor(blocks, b, T->M, &s->factor) : 0;
  s->factored = failed ? -1 : b;
  if (failed) memset(x, 0, (size_t)nsdae_blocks_size(blocks, b) * sizeof *x);
  if (!failed) nsdae_blocks_solve(&s->factor, x);
}

/* Appends a row, with M^-1 W from the value `at` on. Returns where the next one begins. */
static size_t append(nsdae_slop_projection *s, const nsdae_terms *T, const nsdae_rows *rows, int i,
                     size_t at)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int row = s->count++;
  s->weight[row] = s->multiplier[row] = 0;
  s->at[row] = at;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], n = nsdae_blocks_size(blocks, b);
    const double *W = rows->value + rows->at[p];
    double *inverse = s->inverse + at;
    for (int j = 0; j < n; j++) inverse[j] = W[(size_t)j * rows->stride];
    solve_block(s, T, b, inverse);
    for (int j = 0; j < n; j++) s->weight[row] += W[(size_t)j * rows->stride] * inverse[j];
    at += (size_t)n;
  }
  return at;
}

/* row_i . x over block b; k: the number that its part has in most rows. */
static double dot_part(const nsdae_blocks *blocks, const nsdae_rows *rows, int i, int k, int b,
                       const double *x)
{
  int p = rows->first[i] + k, end = rows->first[i + 1];
  double sum = 0;
  if (!(p < end && rows->block[p] == b)) p = rows->first[i];
  while (p < end && rows->block[p] != b) p++;
  if (p == end) return 0;
  const double *value = rows->value + rows->at[p];
  for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++, value += rows->stride)
    sum += *value * x[j];
  return sum;
}

/* a_i of bodies with the accelerations x. */
static double of_bodies(const nsdae_terms *T, int i, const double *x)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const nsdae_rows *W = &T->by.normal;
  int nt = T->system->dims.nt;
  double sum = 0;
  for (int p = W->first[i]; p < W->first[i + 1]; p++) {
    int k = p - W->first[i], b = W->block[p];
    double along = dot_part(blocks, W, i, k, b, x), square = along * along;
    for (int j = i * nt; j < (i + 1) * nt; j++) {
      along = dot_part(blocks, &T->by.tangent, j, k, b, x);
      square += along * along;
    }
    sum += sqrt(square);
  }
  return sum;
}

/* a_i of coordinates that may be those of several bodies. */
static double of_entries(const nsdae_terms *T, int i, const double *x)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int nt = T->system->dims.nt;
  double along = nsdae_rows_dot_sizes(blocks, &T->by.normal, i, x), square = along * along;
  for (int j = i * nt; j < (i + 1) * nt; j++) {
    along = nsdae_rows_dot_sizes(blocks, &T->by.tangent, j, x);
    square += along * along;
  }
  return sqrt(square);
}

static double acceleration(const nsdae_slop_projection *s, const nsdae_terms *T, int i)
{
  double (*of)(const nsdae_terms *, int, const double *) =
      T->system->maker.of ? of_bodies : of_entries;
  double most = of(T, i, s->by.free);
  return s->by.held ? fmax(most, of(T, i, s->by.held)) : most;
}

/* s of contact i; touch: nsdae_terms_touch, a loop over q. */
static double slop_of(const nsdae_slop_projection *s, const nsdae_terms *T, int i, double touch,
                      double h)
{
  return fmax(touch, h * h / 2 * acceleration(s, T, i));
}

/* The gap some steps later, by the velocity u that it leaves with. */
static double gap_by_itself(double gap, double u, double h)
{
  return gap + own_steps * h * fmax(u, 0);
}

/* What each contact misses, and the rows, if one of them is too deep. */
static int begin_island(nsdae_slop_projection *s, int island, const nsdae_terms *T, double touch,
                        double h)
{
  const nsdae_contact_islands *is = &s->end.islands;
  const int *contact = is->contact.of + is->contact.first[island];
  int contacts = nsdae_members_count(&is->contact, island), too_deep = 0;
  size_t at = 0;
  for (int a = 0; a < contacts; a++) {
    int i = contact[a];
    double slop = slop_of(s, T, i, touch, h), gap = T->gap[i];
    s->slop[a] = slop;
    s->missing[a] = gap + slop < 0 ? 0 : gap + slop;
    if (!s->end.closed[i] || !(gap < -deep * slop)) continue;
    gap = gap_by_itself(gap, nsdae_terms_normal_rate(T, i, T->v), h);
    if (gap < -deep * slop) s->missing[a] = gap + slop, too_deep = 1;
  }
  if (!too_deep) return 0;
  s->count = 0;
  s->contacts = contacts;
  for (int a = 0; a < contacts; a++) at = append(s, T, &T->by.normal, contact[a], at);
  for (int i = is->row.first[island]; i < is->row.first[island + 1]; i++) {
    s->missing[s->count] = 0;
    at = append(s, T, &T->by.jacobian, is->row.of[i], at);
  }
  for (int i = is->joint.first[island]; i < is->joint.first[island + 1]; i++) {
    s->missing[s->count] = 0;
    at = append(s, T, &T->by.frictional_joint, is->joint_number[is->joint.of[i]], at);
    if (!s->end.stuck[is->joint_number[is->joint.of[i]]]) s->weight[s->count - 1] = 0;
  }
  return 1;
}

/* ---- projected Gauss-Seidel */

/* d += (M^-1 W) by, of row i of its rows. */
static void add(const nsdae_slop_projection *s, const nsdae_blocks *blocks, const nsdae_rows *rows,
                int i, int row, double by, double *change)
{
  const double *inverse = s->inverse + s->at[row];
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++) change[j] += *inverse++ * by;
  }
}

static const nsdae_rows *row_of(const nsdae_slop_projection *s, int island, const nsdae_terms *T,
                                int row, int *i)
{
  const nsdae_contact_islands *is = &s->end.islands;
  int bilateral = row - s->contacts, joint = bilateral - nsdae_members_count(&is->row, island);
  *i = bilateral < 0 ? is->contact.of[is->contact.first[island] + row]
       : joint < 0   ? is->row.of[is->row.first[island] + bilateral]
                     : is->joint_number[is->joint.of[is->joint.first[island] + joint]];
  return bilateral < 0 ? &T->by.normal : joint < 0 ? &T->by.jacobian : &T->by.frictional_joint;
}

/* The multiplier of a row becomes next, of a contact at least 0. */
static void set_multiplier(nsdae_slop_projection *s, int island, const nsdae_terms *T, int row,
                           double next)
{
  int i;
  const nsdae_rows *rows = row_of(s, island, T, row, &i);
  double was = s->multiplier[row];
  if (row < s->contacts && !(next > 0)) next = 0;
  s->multiplier[row] = next;
  if (next != was) add(s, &T->system->blocks, rows, i, row, next - was, s->change);
}

/* One row; returns how far its contact was from the solution, relative to the slop: beyond it, or
 * above it with a multiplier. */
static double relax(nsdae_slop_projection *s, int island, const nsdae_terms *T, int row)
{
  int i;
  const nsdae_rows *rows = row_of(s, island, T, row, &i);
  double residual = nsdae_rows_add_dot(&T->system->blocks, rows, i, s->change, s->missing[row]);
  double was = s->multiplier[row], by = s->weight[row];
  if (!(by > 0)) return 0;
  set_multiplier(s, island, T, row, was - residual / by);
  return row < s->contacts ? fabs(s->multiplier[row] - was) * by / s->slop[row] : 0;
}

/* l := l + (k - 1) / (k + 2) (l - before), before := l. Returns the next k; it is 1 again after a
 * pair of sweeps against l - before. */
static int extrapolate(nsdae_slop_projection *s, int island, const nsdae_terms *T, int k)
{
  double along = 0, *before = s->last.before, *begun = s->last.begun;
  for (int row = 0; row < s->count; row++) {
    double l = s->multiplier[row];
    along += s->weight[row] * (l - begun[row]) * (l - before[row]);
  }
  if (along < 0) k = 1;
  for (int row = 0; row < s->count; row++) {
    double l = s->multiplier[row], by = (k - 1) / (k + 2.0);
    if (k > 1) set_multiplier(s, island, T, row, l + by * (l - before[row]));
    before[row] = l;
    begun[row] = s->multiplier[row];
  }
  return k + 1;
}

/* A sweep backwards relaxes the rows of Phi_q first and sees what they do to the contacts. */
static void solve_island(nsdae_slop_projection *s, int island, const nsdae_terms *T)
{
  size_t bytes = (size_t)s->count * sizeof(double);
  memset(s->last.before, 0, bytes);
  memset(s->last.begun, 0, bytes);
  for (int pair = 0, k = 1; pair < PAIRS; pair++) {
    double off = 0;
    for (int row = 0; row < s->count; row++) relax(s, island, T, row);
    for (int row = s->count - 1; row >= 0; row--) off = fmax(off, relax(s, island, T, row));
    if (off <= CLOSE * (deep - 1)) return;
    k = extrapolate(s, island, T, k);
  }
}

static void keep_gaps(const nsdae_slop_projection *s, const nsdae_problem *p)
{
  size_t count = (size_t)p->closed->count;
  if (count > 0) memcpy(p->closed->gap, s->gap, count * sizeof *s->gap);
}

double nsdae_slop_find(nsdae_slop_projection *s, const nsdae_problem *p, const nsdae_terms *T,
                       const double *v, const double *held, double rest, double h)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const double touch = nsdae_terms_touch(T);
  double most = 0;
  s->factored = -1;
  memcpy(s->by.free, T->F, (size_t)T->system->dims.nv * sizeof *s->by.free);
  for (int b = 0; b < blocks->count; b++) solve_block(s, T, b, s->by.free + blocks->first[b]);
  s->by.held = held;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    double gap = T->gap[i] + rest * nsdae_terms_normal_rate(T, i, v);
    s->gap[i] = gap;
    if (!(gap < -deep * touch)) continue;
    double slop = slop_of(s, T, i, touch, h);
    gap = gap_by_itself(gap, p->results->after[i], h);
    if (gap < -deep * slop) most = fmax(most, -gap - slop);
  }
  keep_gaps(s, p);
  return most;
}

/* ---- the contacts at the end */

/* Whether contacts have numbers at each point alone. */
static int finds_contacts(const nsdae_system *system)
{
  return nsdae_terms_most(system) == NSDAE_ANY_NUMBER;
}

/* Number at the end of closed contact a. */
static int number_at_end(const nsdae_problem *p, int a)
{
  return finds_contacts(p->system) ? p->picked.place[a] : p->number[a];
}

/* Those within reach, and their islands. Closed contacts of a list that are farther have gap =
 * reach there, by nsdae_problem_update. */
static int find_contacts(nsdae_slop_projection *s, nsdae_problem *p, nsdae_terms *end, double reach)
{
  int near = 0, count = p->system->dims.k;
  if (finds_contacts(p->system)) {
    int status = nsdae_problem_update(p, end, reach);
    if (status < 0) return status;
    count = end->by.list.count;
    nsdae_terms_select(end, count, NULL);
  }
  for (int i = 0; i < count; i++) {
    s->end.closed[i] = 0;
    if (end->gap[i] < reach) s->end.number[near++] = i;
  }
  for (int a = 0; a < p->count; a++) {
    int j = number_at_end(p, a);
    s->end.closed[j] = 1;
    if (end->gap[j] < reach) s->gap[p->number[a]] = end->gap[j];
  }
  for (int j = 0; j < p->system->dims.f; j++)
    s->end.stuck[j] = p->results->frictional_joint_mode[j] == NSDAE_MODE_STICK &&
                      !p->system->frictional_joint[j].position;
  nsdae_contact_islands_find(&s->end.islands, end, near, s->end.number);
  return NSDAE_OK;
}

int nsdae_slop_solve(nsdae_slop_projection *s, nsdae_problem *p, nsdae_terms *end, double reach,
                     double h)
{
  int moved = 0, status = find_contacts(s, p, end, reach);
  if (status < 0) return status;
  const double touch = nsdae_terms_touch(end);
  s->factored = -1;
  memset(s->change, 0, (size_t)p->system->dims.nv * sizeof *s->change);
  for (int island = 0; island < s->end.islands.count; island++) {
    if (!begin_island(s, island, end, touch, h)) continue;
    moved++;
    solve_island(s, island, end);
  }
  return moved;
}

void nsdae_slop_moved(nsdae_slop_projection *s, const nsdae_problem *p, const nsdae_terms *end,
                      const double *change)
{
  for (int i = 0; i < p->system->dims.k; i++) s->moved[i] = 0;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a], j = number_at_end(p, a);
    s->moved[i] = nsdae_rows_dot(&p->system->blocks, &end->by.normal, j, change);
    s->gap[i] += s->moved[i];
  }
  keep_gaps(s, p);
}
