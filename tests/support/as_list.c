#include "as_list.h"

#include <stdlib.h>
#include <string.h>

#include "listed.h"

struct as_list {
  const nsdae_system *of;
  nsdae_system *list;
  nsdae_differences differences;
  nsdae_evals evals;
  nsdae_terms terms; /* of the fixed contacts at the point in work */
  nsdae_arena arena;
  double *wide[2], *row; /* nv (1 + nt), nv */
  int hidden, all;
  long calls;
};

static void lay_out(void *object, nsdae_arena *arena)
{
  as_list *a = object;
  const nsdae_dims *d = &a->of->dims;
  nsdae_differences_layout(&a->differences, arena);
  nsdae_terms_layout(&a->terms, arena);
  for (int s = 0; s < 2; s++) a->wide[s] = NSDAE_ARENA_DOUBLES(arena, d->nv * (1L + d->nt));
  a->row = NSDAE_ARENA_DOUBLES(arena, d->nv);
}

/* Terms of the fixed contacts, at v if it is given: 0, or the code of a callback. */
static int evaluate(as_list *a, double t, const double *q, const double *v, unsigned which)
{
  const double *at = v ? v : a->row;
  if (!v) memset(a->row, 0, (size_t)a->of->dims.nv * sizeof *a->row);
  nsdae_terms_at(&a->terms, t, q, at);
  int status = nsdae_terms_need(&a->terms, which);
  while (status == NSDAE_ARRAYS_GROW) {
    const nsdae_room none = {0}, *taken = &a->terms.by.rows.taken;
    if (nsdae_terms_grow(&a->terms, &none, taken) < 0) return -1;
    status = nsdae_terms_need(&a->terms, which);
  }
  return status < 0 ? -1 : 0;
}

/* ---- what both share */

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const as_list *a = user;
  return a->of->call.force(t, q, v, F, a->of->user);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const as_list *a = user;
  return a->of->call.constraint(t, q, phi, a->of->user);
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const as_list *a = user;
  return a->of->call.constraint_bias(t, q, v, phi_t, omega, a->of->user);
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const as_list *a = user;
  return a->of->call.kinematics(t, q, v, qdot, a->of->user);
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const as_list *a = user;
  return a->of->call.potential(t, q, energy, a->of->user);
}

/* ---- by blocks */

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  as_list *a = user;
  const nsdae_blocks *to = &a->list->blocks, *from = &a->of->blocks;
  int code = evaluate(a, t, q, NULL, NSDAE_TERM_MASS);
  for (int b = 0; b < to->count && code == 0; b++)
    for (int j = to->first[b]; j < to->first[b + 1]; j++)
      for (int i = to->first[b]; i < to->first[b + 1]; i++) {
        int of = 0;
        while (from->first[of + 1] <= j) of++;
        int inside = i >= from->first[of] && i < from->first[of + 1];
        int n = nsdae_blocks_size(from, of), at = (j - from->first[of]) * n + i - from->first[of];
        *M++ = inside ? a->terms.M[from->square[of] + (size_t)at] : 0;
      }
  return code;
}

/* Row i in full: the entries of its parts. */
static const double *spread(const as_list *a, const nsdae_rows *rows, int i)
{
  memset(a->row, 0, (size_t)a->of->dims.nv * sizeof *a->row);
  nsdae_rows_gather(&a->of->blocks, rows, i, a->of->blocks.first, a->row, 1);
  return a->row;
}

static int is_zero(int n, const double *a)
{
  while (n > 0 && a[n - 1] == 0) n--;
  return n == 0;
}

static int constraint_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  as_list *a = user;
  const nsdae_blocks *blocks = &a->list->blocks;
  int code = evaluate(a, t, q, NULL, NSDAE_TERM_JACOBIAN);
  for (int i = 0; i < a->of->dims.m && code == 0; i++) {
    const double *row = spread(a, &a->terms.by.jacobian, i);
    for (int b = 0; b < blocks->count; b++) {
      int n = nsdae_blocks_size(blocks, b);
      if (blocks->count > 1 && is_zero(n, row + blocks->first[b])) continue;
      nsdae_row_add(rows, i, b, row + blocks->first[b]);
    }
  }
  return code;
}

static int damping(double t, const double *q, const double *v, nsdae_block_list *blocks, void *user)
{
  as_list *a = user;
  int nv = a->of->dims.nv, code = -1;
  double *D = calloc((size_t)nv * (size_t)nv, sizeof *D);
  if (D) code = a->of->call.force_damping(t, q, v, D, nv, a->of->user);
  if (code == 0) nsdae_block_add(blocks, 0, 0, D);
  free(D);
  return code;
}

static int stiffness(double t, const double *q, const double *v, nsdae_block_list *blocks,
                     void *user)
{
  as_list *a = user;
  int nv = a->of->dims.nv, code = -1;
  double *K = calloc((size_t)nv * (size_t)nv, sizeof *K);
  if (K) code = a->of->call.force_stiffness(t, q, v, K, nv, a->of->user);
  if (code == 0) nsdae_block_add(blocks, 0, 0, K);
  free(K);
  return code;
}

static int damping_blocks(double t, const double *q, const double *v, nsdae_block_list *blocks,
                          void *user)
{
  const as_list *a = user;
  return a->of->call.force_damping_blocks(t, q, v, blocks, a->of->user);
}

static int stiffness_blocks(double t, const double *q, const double *v, nsdae_block_list *blocks,
                            void *user)
{
  const as_list *a = user;
  return a->of->call.force_stiffness_blocks(t, q, v, blocks, a->of->user);
}

/* ---- frictional joints */

static int joint_friction_rows(double t, const double *q, nsdae_row_list *rows, double *w,
                               void *user)
{
  as_list *a = user;
  const nsdae_blocks *blocks = &a->list->blocks;
  int code = evaluate(a, t, q, NULL, NSDAE_TERM_SLIDE);
  for (int i = 0; i < a->of->dims.f && code == 0; i++) {
    const double *row = spread(a, &a->terms.by.frictional_joint, i);
    w[i] = a->terms.frictional_joint.w[i];
    for (int b = 0; b < blocks->count; b++) {
      int n = nsdae_blocks_size(blocks, b);
      if (blocks->count > 1 && is_zero(n, row + blocks->first[b])) continue;
      nsdae_row_add(rows, i, b, row + blocks->first[b]);
    }
  }
  return code;
}

/* ---- contacts */

/* Direction d of the contact from a row in full; blocks join as they are met. 0: more than two. */
static int add_direction(const as_list *a, nsdae_contact *c, int d, const double *row)
{
  const nsdae_blocks *blocks = &a->list->blocks;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b), s = c->block[0] == b ? 0 : c->block[1] == b ? 1 : -1;
    if (s < 0 && is_zero(n, row + blocks->first[b])) continue;
    if (s < 0) s = c->block[0] < 0 ? 0 : c->block[1] < 0 ? 1 : -1;
    if (s < 0) return 0;
    c->block[s] = b;
    size_t bytes = (size_t)n * sizeof *row;
    memcpy(a->wide[s] + (size_t)d * (size_t)n, row + blocks->first[b], bytes);
  }
  return 1;
}

static void set_sides(const as_list *a, nsdae_contact *c)
{
  for (int s = 0; s < 2; s++) {
    if (c->block[s] < 0) continue;
    size_t n = (size_t)nsdae_blocks_size(&a->list->blocks, c->block[s]);
    if (n > NSDAE_CONTACT_WIDTH) c->wide[s] = a->wide[s];
    for (size_t d = 0; d <= (size_t)a->of->dims.nt && n <= NSDAE_CONTACT_WIDTH; d++)
      memcpy(c->direction[s][d], a->wide[s] + d * n, n * sizeof(double));
  }
}

static int add_contact(as_list *a, int i, nsdae_contact_list *list)
{
  const nsdae_terms *T = &a->terms;
  const nsdae_coefficients *law = &a->of->contact[i];
  int nt = a->of->dims.nt;
  nsdae_contact c = {.id = i,
                     .block = {-1, -1},
                     .gap = T->gap[i],
                     .mu = law->mu,
                     .e_n = law->e_n,
                     .e_t = law->e_t,
                     .w = {T->w_N[i]},
                     .omega_given = a->of->call.contact_acceleration != NULL};
  if (a->list->blocks.count == 1) c.block[0] = 0; /* zero directions too */
  size_t most = (size_t)a->of->dims.nv * (size_t)(1 + nt) * sizeof(double);
  for (int s = 0; s < 2; s++) memset(a->wide[s], 0, most);
  if (!add_direction(a, &c, 0, spread(a, &T->by.normal, i))) return -1;
  for (int d = 1; d <= nt; d++) {
    c.w[d] = T->w_T[i * nt + d - 1];
    if (!add_direction(a, &c, d, spread(a, &T->by.tangent, i * nt + d - 1))) return -1;
  }
  for (int d = 0; c.omega_given && d <= nt; d++)
    c.omega[d] = d == 0 ? T->omega.N[i] : T->omega.T[i * nt + d - 1];
  set_sides(a, &c);
  nsdae_contact_add(list, &c);
  return 0;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  as_list *a = user;
  unsigned terms = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS;
  if (a->of->call.contact_acceleration) terms |= NSDAE_TERM_ACCELERATION;
  a->calls++;
  int code = evaluate(a, t, q, v, terms);
  for (int i = 0; i < a->of->dims.k && code == 0; i++)
    if (i != a->hidden && (a->all || a->terms.gap[i] <= reach)) code = add_contact(a, i, list);
  return code;
}

/* ---- the copy */

static void set_callbacks(as_list *a)
{
  nsdae_system *s = a->list;
  const nsdae_calls *call = &a->of->call;
  const nsdae_dims *d = &a->of->dims;
  nsdae_system_set_user(s, a);
  nsdae_system_set_mass_blocks(s, mass_blocks);
  nsdae_system_set_force(s, force);
  if (call->kinematics) nsdae_system_set_kinematics(s, kinematics);
  if (call->potential) nsdae_system_set_potential(s, potential);
  if (call->force_damping && s->blocks.count == 1)
    nsdae_system_set_force_damping_blocks(s, damping);
  if (call->force_stiffness && s->blocks.count == 1)
    nsdae_system_set_force_stiffness_blocks(s, stiffness);
  if (call->force_damping_blocks) nsdae_system_set_force_damping_blocks(s, damping_blocks);
  if (call->force_stiffness_blocks) nsdae_system_set_force_stiffness_blocks(s, stiffness_blocks);
  if (d->m > 0) nsdae_system_set_constraint(s, constraint);
  if (d->m > 0) nsdae_system_set_constraint_rows(s, constraint_rows);
  if (d->m > 0 && call->constraint_bias) nsdae_system_set_constraint_bias(s, constraint_bias);
  for (int j = 0; j < d->f; j++) {
    const nsdae_frictional_joint *joint = &a->of->frictional_joint[j];
    if (d->m > 0) nsdae_system_set_frictional_joint(s, j, joint->constraint, joint->mu);
    nsdae_system_set_friction_bound(s, j, joint->bound);
  }
  if (d->f > 0) nsdae_system_set_joint_friction_rows(s, joint_friction_rows);
  nsdae_system_set_contacts(s, contacts);
}

static int set_blocks(as_list *a, int count, const int *nq, const int *nv)
{
  const nsdae_blocks *v = &a->of->blocks, *q = &a->of->coordinates;
  if (count > 0) return nsdae_system_set_blocks(a->list, count, nq, nv);
  int *size = calloc(2 * (size_t)v->count, sizeof *size), status = NSDAE_E_MEMORY;
  for (int b = 0; size && b < v->count; b++) {
    size[b] = nsdae_blocks_size(q, b);
    size[v->count + b] = nsdae_blocks_size(v, b);
  }
  if (size) status = nsdae_system_set_blocks(a->list, v->count, size, size + v->count);
  free(size);
  return status;
}

as_list *as_list_create(const nsdae_system *system, int count, const int *nq, const int *nv)
{
  as_list *a = calloc(1, sizeof *a);
  nsdae_dims dims = system->dims;
  if (!a) return NULL;
  dims.k = 0;
  a->of = system;
  a->hidden = -1;
  a->differences.system = a->terms.system = system;
  a->terms.differences = &a->differences;
  a->terms.evals = &a->evals;
  int status = nsdae_arena_build(&a->arena, lay_out, a);
  if (status == NSDAE_OK) status = nsdae_system_create(&dims, &a->list, NULL);
  if (status == NSDAE_OK) status = set_blocks(a, count, nq, nv);
  if (status == NSDAE_OK) {
    set_callbacks(a);
    return a;
  }
  as_list_destroy(a);
  return NULL;
}

void as_list_destroy(as_list *a)
{
  if (!a) return;
  nsdae_system_destroy(&a->list);
  nsdae_terms_release(&a->terms);
  nsdae_arena_release(&a->arena);
  free(a);
}

nsdae_system *as_list_system(const as_list *a)
{
  return a->list;
}

void as_list_hide(as_list *a, int contact)
{
  a->hidden = contact;
}

void as_list_list_all(as_list *a, int all)
{
  a->all = all;
}

long as_list_calls(const as_list *a)
{
  return a->calls;
}
