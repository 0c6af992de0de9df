/* The certificate of a step, one over all its islands, computed again from M, J, q and the impulses
 * as they are handed over: islands of every kind and of scales apart by decades, in one step. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { GROUPS = 6, BLOCKS = 200, CONTACTS = 300, ROWS = 20, V = 6, STEPS = 4 };

typedef struct contact {
  int block[2];
  double open; /* its gap */
  double mu, e_n, e_t, w[3], direction[2][3][V];
} contact;

typedef struct row {
  int block[2];
  double value[2][V];
} row;

typedef struct scene {
  int nt, blocks, contacts, rows;
  double M[BLOCKS][V * V], F[BLOCKS][V], v0[BLOCKS][V];
  contact contact[CONTACTS];
  row row[ROWS];
  int held[BLOCKS]; /* of a chain by rows that is touched */
} scene;

/* A group of blocks, and what touches them; rows between neighbours. */
typedef struct group {
  int blocks, contacts, rows;
  double friction, restitution, belt; /* upper ends */
} group;

static random_state draws;

static double draw(void)
{
  return random_number(&draws);
}

static double draw_decades(double most)
{
  return pow(10, most * draw());
}

/* Positive definite, of random axes. */
static void draw_mass(double *M, double scale)
{
  double A[V][V];
  for (int i = 0; i < V; i++)
    for (int j = 0; j < V; j++) A[i][j] = draw();
  for (int i = 0; i < V; i++)
    for (int j = 0; j < V; j++) {
      double sum = i == j ? 0.3 : 0;
      for (int l = 0; l < V; l++) sum += A[i][l] * A[j][l];
      M[V * i + j] = scale * sum;
    }
}

static void draw_contact(scene *s, const group *g, int first)
{
  contact *c = &s->contact[s->contacts++];
  *c = (contact){.mu = g->friction * fabs(draw()),
                 .e_n = g->restitution * fabs(draw()),
                 .e_t = g->restitution * fabs(draw())};
  c->block[0] = first + random_int(&draws, 0, g->blocks - 1);
  c->block[1] = g->blocks > 1 && random_int(&draws, 0, 3) > 0 ? c->block[0] : -1;
  while (c->block[1] == c->block[0]) c->block[1] = first + random_int(&draws, 0, g->blocks - 1);
  if (random_int(&draws, 0, 9) == 0) c->open = 1;
  if (random_int(&draws, 0, 2) == 0) c->mu = 0;
  if (s->nt == 0) c->mu = 0;
  for (int d = 0; d < 3; d++) {
    if (random_int(&draws, 0, 1)) c->w[d] = g->belt * draw();
    for (int side = 0; side < 2; side++)
      for (int j = 0; j < V; j++) c->direction[side][d][j] = draw();
  }
}

static void draw_group(scene *s, const group *g)
{
  int first = s->blocks;
  double mass = draw_decades(2), speed = draw_decades(3);
  for (int b = 0; b < g->blocks; b++, s->blocks++) {
    draw_mass(s->M[s->blocks], mass);
    for (int j = 0; j < V; j++) {
      s->F[s->blocks][j] = 1e2 * mass * speed * draw();
      s->v0[s->blocks][j] = g->rows > 0 ? 0 : speed * draw();
    }
  }
  for (int i = 0; i < g->contacts; i++) draw_contact(s, g, first);
  for (int i = s->contacts - g->contacts; i < s->contacts; i++)
    for (int side = 0; side < 2; side++) {
      const contact *c = &s->contact[i];
      int touched = c->open == 0 && c->block[side] >= 0 && c->block[side] <= first + g->rows;
      for (int b = first; b <= first + g->rows && touched; b++) s->held[b] = 1;
    }
  for (int i = 0; i < g->rows; i++) {
    row *r = &s->row[s->rows++];
    r->block[0] = first + i;
    r->block[1] = first + i + 1;
    for (int side = 0; side < 2; side++)
      for (int j = 0; j < V; j++) r->value[side][j] = draw();
  }
}

/* ---- as a system: everything is constant, and closed */

static int mass(double t, const double *q, double *M, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  memcpy(M, s->M, (size_t)s->blocks * sizeof *s->M);
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)v;
  memcpy(F, s->F, (size_t)s->blocks * sizeof *s->F);
  return 0;
}

static double row_times(const row *r, const double *v)
{
  double sum = 0;
  for (int side = 0; side < 2; side++)
    for (int j = 0; j < V; j++) sum += r->value[side][j] * v[V * r->block[side] + j];
  return sum;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const scene *s = user;
  (void)t;
  for (int i = 0; i < s->rows; i++) phi[i] = row_times(&s->row[i], q);
  return 0;
}

static int constraint_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  for (int i = 0; i < s->rows; i++)
    for (int side = 0; side < 2; side++)
      if (nsdae_row_add(rows, i, s->row[i].block[side], s->row[i].value[side]) < 0) return -1;
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < s->rows; i++) phi_t[i] = omega[i] = 0;
  return 0;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)v;
  (void)reach;
  for (int i = 0; i < s->contacts; i++) {
    const contact *from = &s->contact[i];
    nsdae_contact c = {.id = i,
                       .block = {from->block[0], from->block[1]},
                       .gap = from->open,
                       .mu = from->mu,
                       .e_n = from->e_n,
                       .e_t = from->e_t};
    memcpy(c.w, from->w, sizeof c.w);
    memcpy(c.direction, from->direction, sizeof c.direction);
    if (nsdae_contact_add(list, &c) < 0) return -1;
  }
  return 0;
}

static nsdae_system *describe(scene *s)
{
  static int sizes[BLOCKS];
  nsdae_system *system;
  const nsdae_dims dims = {.nq = V * s->blocks, .m = s->rows, .nt = s->nt};
  for (int i = 0; i < BLOCKS; i++) sizes[i] = V;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, s);
  nsdae_system_set_blocks(system, s->blocks, sizes, sizes);
  nsdae_system_set_mass_blocks(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_contacts(system, contacts);
  if (s->rows > 0) {
    nsdae_system_set_constraint(system, constraint);
    nsdae_system_set_constraint_rows(system, constraint_rows);
    nsdae_system_set_constraint_bias(system, constraint_bias);
  }
  return system;
}

/* ---- the certificate again */

/* x := M^-1 x by elimination; M is positive definite. */
static void solve(const double *M, double *x)
{
  double A[V][V + 1];
  for (int i = 0; i < V; i++) {
    memcpy(A[i], M + V * i, V * sizeof *M);
    A[i][V] = x[i];
  }
  for (int k = 0; k < V; k++)
    for (int i = k + 1; i < V; i++)
      for (int j = V; j >= k; j--) A[i][j] -= A[i][k] / A[k][k] * A[k][j];
  for (int i = V - 1; i >= 0; i--) {
    x[i] = A[i][V];
    for (int j = i + 1; j < V; j++) x[i] -= A[i][j] * x[j];
    x[i] /= A[i][i];
  }
}

static int rows_of(const scene *s, const contact *c)
{
  return c->mu > 0 ? 1 + s->nt : 1;
}

static double direction_times(const contact *c, int d, const double *v)
{
  double sum = 0;
  for (int side = 0; side < 2; side++)
    for (int j = 0; j < V && c->block[side] >= 0; j++)
      sum += c->direction[side][d][j] * v[V * c->block[side] + j];
  return sum;
}

/* W_d^T M^-1 W_d of a direction */
static double inverse_mass(const scene *s, const contact *c, int d)
{
  double sum = 0;
  for (int side = 0; side < 2; side++) {
    double x[V];
    if (c->block[side] < 0) continue;
    memcpy(x, c->direction[side][d], sizeof x);
    solve(s->M[c->block[side]], x);
    for (int j = 0; j < V; j++) sum += c->direction[side][d][j] * x[j];
  }
  return sum;
}

/* Largest entry of x - P(x - y), of the cone |x_T| <= mu x_N, by the projection as it is defined.
 */
static double natural(int rows, double mu, const double *x, const double *y)
{
  double z[3] = {0}, slip = 0, most = 0;
  for (int k = 1; k < rows; k++) slip = hypot(slip, y[k]);
  for (int k = 0; k < rows; k++) z[k] = x[k] - y[k] - (k == 0 ? mu * slip : 0);
  double t = hypot(z[1], z[2]), n = (z[0] + mu * t) / (1 + mu * mu);
  if (z[0] < 0 || t > mu * z[0]) {
    double tangent = t > 0 && n > 0 ? mu * n / t : 0;
    z[0] = n > 0 ? n : 0;
    z[1] *= tangent;
    z[2] *= tangent;
  }
  for (int k = 0; k < rows; k++) most = fmax(most, fabs(x[k] - z[k]));
  return most;
}

/* before: v the step began with; free and v: without impulses and with them. */
static double certificate(const scene *s, const nsdae_record *r, const double *before,
                          const double *free, const double *v)
{
  double left = 0, scale = 0;
  for (int i = 0; i < r->contacts.count; i++) {
    const contact *c = &s->contact[r->contacts.id[i]];
    int rows = rows_of(s, c);
    double x[3] = {r->contacts.normal_impulse[i]}, u[3] = {0}, d = 0;
    for (int k = 0; k < rows; k++) {
      double w = c->w[k] + (k == 0 ? c->e_n : c->e_t) * (direction_times(c, k, before) + c->w[k]);
      if (k > 0) x[k] = r->contacts.tangential_impulse[i * s->nt + k - 1];
      u[k] = direction_times(c, k, v) + w;
      scale = fmax(scale, fabs(direction_times(c, k, free) + w));
      d += inverse_mass(s, c, k) / rows;
    }
    for (int k = 0; k < rows; k++) x[k] *= d;
    left = fmax(left, natural(rows, c->mu, x, u));
  }
  for (int i = 0; i < s->rows; i++) {
    if (!s->held[s->row[i].block[0]]) continue; /* no contact asks for anything there */
    left = fmax(left, fabs(row_times(&s->row[i], v)));
    scale = fmax(scale, fabs(row_times(&s->row[i], free)));
  }
  return scale > 0 ? left / scale : left;
}

static double again(const scene *s, const nsdae_record *r, double h, const double *before)
{
  static double free[V * BLOCKS], v[V * BLOCKS];
  for (int b = 0; b < s->blocks; b++)
    for (int i = 0; i < V; i++) {
      double sum = h * s->F[b][i];
      for (int j = 0; j < V; j++) sum += s->M[b][V * i + j] * before[V * b + j];
      free[V * b + i] = v[V * b + i] = sum;
    }
  for (int i = 0; i < r->contacts.count; i++) {
    const contact *c = &s->contact[r->contacts.id[i]];
    for (int k = 0; k < rows_of(s, c); k++) {
      double x = k == 0 ? r->contacts.normal_impulse[i]
                        : r->contacts.tangential_impulse[i * s->nt + k - 1];
      for (int side = 0; side < 2; side++)
        for (int j = 0; j < V && c->block[side] >= 0; j++)
          v[V * c->block[side] + j] += c->direction[side][k][j] * x;
    }
  }
  for (int i = 0; i < s->rows; i++)
    for (int side = 0; side < 2; side++)
      for (int j = 0; j < V; j++)
        v[V * s->row[i].block[side] + j] -= s->row[i].value[side][j] * h * r->multiplier[i];
  for (int b = 0; b < s->blocks; b++) {
    solve(s->M[b], free + V * b);
    solve(s->M[b], v + V * b);
  }
  return certificate(s, r, before, free, v);
}

/* Steps of a scene; how many were solved, and of these how many left more than rounding. */
static int check_scene(scene *s, double tol, int *rough)
{
  const double h = 1e-3;
  static double q0[V * BLOCKS], before[V * BLOCKS];
  nsdae_system *system = describe(s);
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  int solved = 0;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = h;
  options.contact_tol = tol;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q0, s->v0[0]);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  memcpy(before, s->v0, sizeof before);
  for (int n = 0; n < STEPS && nsdae_sim_step(sim) >= 0; n++, solved++) {
    nsdae_sim_get_record(sim, &r);
    double own = again(s, &r, r.duration, before);
    assert_near(r.lcp_residual, own, 1e-3 * own + 1e-11);
    assert_at_most(r.lcp_residual, tol);
    *rough += own > 1e-9;
    memcpy(before, r.v, (size_t)(V * s->blocks) * sizeof *before);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return solved;
}

/* One contact, few, many without friction, many with it, with constraints, constraints alone. */
static const group kinds[GROUPS] = {{.blocks = 1, .contacts = 1, .friction = 1, .restitution = 1},
                                    {.blocks = 3, .contacts = 6, .friction = 0.7, .belt = 1},
                                    {.blocks = 40, .contacts = 60, .restitution = 0.5},
                                    {.blocks = 20, .contacts = 40, .friction = 0.7},
                                    {.blocks = 6, .contacts = 5, .rows = 4, .friction = 0.5},
                                    {.blocks = 4, .rows = 3}};

static void test_one_certificate(void **state)
{
  static scene s;
  int solved = 0, rough = 0;
  (void)state;
  for (uint64_t seed = 0; seed < 300; seed++) {
    draws = (random_state){seed};
    s = (scene){.nt = (int)(seed % 3)};
    for (int i = random_int(&draws, 2, 5); i > 0; i--)
      draw_group(&s, &kinds[random_int(&draws, 0, GROUPS - 1)]);
    if (s.contacts > 0) solved += check_scene(&s, seed % 2 ? 1e-4 : 1e-10, &rough);
  }
  print_message("%d steps, %d of which leave more than rounding\n", solved, rough);
  assert_true(solved > 1000 && rough > 100);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_one_certificate)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
