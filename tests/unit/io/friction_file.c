/* Frictional contact problems in files of FCLIB: there and back to the last bit, every form that
 * the layout has, and what is refused. */
#include "check.h"

#include <hdf5.h>
#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <unistd.h>

#include "friction_families.h"

static const char *const path = "test_friction_file.h5";

static int rows_of(const nsdae_friction_problem *p, int item)
{
  if (item >= p->contacts) return 1;
  return p->rows ? p->rows[item] : 3;
}

static int all_rows(const nsdae_friction_problem *p)
{
  int sum = 0;
  for (int i = 0; i < p->contacts + p->bilateral; i++) sum += rows_of(p, i);
  return sum;
}

static size_t all_values(const nsdae_friction_problem *p)
{
  size_t sum = 0;
  for (int i = 0; i < p->contacts + p->bilateral; i++)
    for (int k = p->first[i]; k < p->first[i + 1]; k++) {
      int b = p->block[k];
      sum += (size_t)rows_of(p, i) *
             (size_t)(p->form == NSDAE_FRICTION_LOCAL ? rows_of(p, b) : p->size[b]);
    }
  return sum;
}

static void same_reals(size_t n, const double *a, const double *b)
{
  assert_true((a == NULL) == (b == NULL));
  for (size_t i = 0; a && i < n; i++) assert_true(a[i] == b[i]);
}

static void same_ints(int n, const int *a, const int *b)
{
  for (int i = 0; i < n; i++) assert_int_equal(a[i], b[i]);
}

static void same_problem(const nsdae_friction_problem *a, const nsdae_friction_problem *b)
{
  int items = a->contacts + a->bilateral, n = 0;
  size_t of_M = 0;
  assert_int_equal(a->form, b->form);
  assert_int_equal(a->contacts, b->contacts);
  assert_int_equal(a->bilateral, b->bilateral);
  assert_int_equal(a->blocks, b->blocks);
  for (int i = 0; i < items; i++) assert_int_equal(rows_of(a, i), rows_of(b, i));
  for (int c = 0; c < a->contacts; c++)
    if (rows_of(a, c) > 1) assert_true(a->mu[c] == b->mu[c]);
  same_reals((size_t)all_rows(a), a->w, b->w);
  same_reals((size_t)all_rows(a), a->compliance, b->compliance);
  same_ints(items + 1, a->first, b->first);
  same_ints(a->first[items], a->block, b->block);
  same_reals(all_values(a), a->value, b->value);
  for (int k = 0; k < a->blocks; k++) {
    assert_int_equal(a->size[k], b->size[k]);
    n += a->size[k];
    of_M += (size_t)a->size[k] * (size_t)a->size[k];
  }
  if (a->blocks == 0) return;
  same_reals(of_M, a->M, b->M);
  same_reals((size_t)n, a->f, b->f);
}

/* Writes it with a guess and a solution, reads it again, and solves both. */
static void there_and_back(const nsdae_friction_problem *p)
{
  size_t m = (size_t)all_rows(p);
  nsdae_friction_file file;
  nsdae_error error;
  nsdae_friction_info first, second;
  double *r = calloc(5 * m + 1, sizeof *r), *u = r + m, *x = u + m, *y = x + m, *low = y + m;
  for (size_t i = 0; i < m; i++) r[i] = 0.5 + (double)i, low[i] = 1e-17 * (3 + (double)i);
  const nsdae_friction_points points = {.guess = r, .r = r, .u = r, .low = low};
  const nsdae_friction_origin origin = {
      .time = 0.25, .step = 3, .tol = 1e-9, .refine = 2, .method = "moreau"};
  int status = nsdae_friction_write(path, p, &points, &origin, &error);
  if (status < 0) fail_msg("%s", error.text);
  status = nsdae_friction_read(path, &file, &error);
  if (status < 0) fail_msg("%s", error.text);
  same_problem(p, &file.problem);
  same_reals(m, r, file.guess);
  same_reals(m, r, file.r);
  same_reals(m, low, file.low);
  assert_true(file.tol == 1e-9 && file.refine == 2 && file.asymmetry == 0);
  memcpy(x, r, m * sizeof *x);
  status = nsdae_friction_solve(p, NULL, r, u, &first);
  assert_int_equal(nsdae_friction_solve(&file.problem, NULL, x, y, &second), status);
  same_reals(m, r, x);
  same_reals(m, u, y);
  assert_true(first.residual == second.residual && first.sweeps == second.sweeps);
  nsdae_friction_file_release(&file);
  assert_null(file.problem.value);
  assert_null(file.low);
  free(r);
}

static void test_there_and_back(void **state)
{
  (void)state;
  for (int family = 0; family < FRICTION_FAMILIES; family++) {
    friction_sample s;
    friction_local local;
    friction_sample_draw(&s, family, 40, 11);
    there_and_back(&s.problem);
    friction_sample_local(&s, &local);
    there_and_back(&local.problem);
    friction_local_release(&local);
    friction_sample_release(&s);
  }
}

/* Two points of mass 2 and 3 with three contacts of three, two and one rows, two bilateral rows,
 * compliance; blocks in an order of their own. */
typedef struct mixed {
  int size[2], first[6], block[8], rows[3];
  double M[18], f[6], mu[3], w[8], compliance[8], value[40];
  nsdae_friction_problem problem;
} mixed;

static void make_mixed(mixed *s)
{
  static const int first[6] = {0, 2, 3, 4, 6, 7}, block[7] = {1, 0, 0, 1, 0, 1, 0};
  *s = (mixed){.size = {3, 3}, .rows = {3, 2, 1}, .mu = {0.5, 0.25, NAN}};
  memcpy(s->first, first, sizeof first);
  memcpy(s->block, block, sizeof block);
  for (int i = 0; i < 18; i++) s->M[i] = i % 9 % 4 == 0 ? 2 + (i >= 9) : 0;
  for (int i = 0; i < 6; i++) s->f[i] = -1 + 0.3 * i;
  for (int i = 0; i < 8; i++) {
    s->w[i] = 0.1 * i;
    s->compliance[i] = i % 3 ? 0 : 0.01;
  }
  for (int i = 0; i < 40; i++) s->value[i] = (i * 7 % 11 - 5) / 4.0;
  s->problem = (nsdae_friction_problem){.contacts = 3,
                                        .bilateral = 2,
                                        .rows = s->rows,
                                        .mu = s->mu,
                                        .w = s->w,
                                        .compliance = s->compliance,
                                        .blocks = 2,
                                        .size = s->size,
                                        .M = s->M,
                                        .f = s->f,
                                        .first = s->first,
                                        .block = s->block,
                                        .value = s->value};
}

static void test_mixed(void **state)
{
  (void)state;
  mixed s;
  make_mixed(&s);
  there_and_back(&s.problem);
  s.problem.compliance = NULL;
  there_and_back(&s.problem);
  s.mu[2] = 0.125;
  for (int c = 0; c < 3; c++) s.rows[c] = 2;
  there_and_back(&s.problem); /* planar: spacedim 2, and no rows of their own */
}

/* Files by hand. */

/* A dataset of n numbers, of which there must be no more. */
static void take_reals(const char *name, int n, double *values)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
  if (set < 0) fail_msg("no %s", name);
  hid_t space = H5Dget_space(set);
  assert_int_equal(H5Sget_simple_extent_npoints(space), n);
  H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(file);
}

static int has(const char *name)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  int found = H5Lexists(file, name, H5P_DEFAULT) > 0;
  H5Fclose(file);
  return found;
}

static void put(hid_t file, const char *name, hid_t type, int n, const void *values)
{
  hsize_t length = (hsize_t)n;
  hid_t links = H5Pcreate(H5P_LINK_CREATE), space = H5Screate_simple(1, &length, NULL);
  H5Pset_create_intermediate_group(links, 1);
  hid_t set = H5Dcreate2(file, name, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
  assert_true(set >= 0);
  H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  H5Dclose(set);
  H5Sclose(space);
  H5Pclose(links);
}

static void put_ints(hid_t file, const char *name, int n, const int *values)
{
  put(file, name, H5T_NATIVE_INT, n, values);
}

static void put_reals(hid_t file, const char *name, int n, const double *values)
{
  put(file, name, H5T_NATIVE_DOUBLE, n, values);
}

typedef struct sparse {
  int m, n, nz, of_p, count;
  int p[16], i[16];
  double x[16];
} sparse;

static void put_matrix(hid_t file, const char *group, const sparse *s)
{
  char name[64];
  const int one[] = {s->m, s->n, s->nz, s->count};
  static const char *const sizes[] = {"m", "n", "nz", "nzmax"};
  for (int k = 0; k < 4; k++) {
    snprintf(name, sizeof name, "%s/%s", group, sizes[k]);
    put_ints(file, name, 1, &one[k]);
  }
  snprintf(name, sizeof name, "%s/p", group);
  put_ints(file, name, s->of_p, s->p);
  snprintf(name, sizeof name, "%s/i", group);
  put_ints(file, name, s->count, s->i);
  snprintf(name, sizeof name, "%s/x", group);
  put_reals(file, name, s->count, s->x);
}

/* One planar contact: W = [2 1; 1 3] unless said otherwise. */
typedef struct local_file {
  sparse W;
  int spacedim, of_mu, of_q;
  double mu[2], q[3];
} local_file;

static const local_file right = {.W = {2, 2, -1, 3, 4, {0, 2, 4}, {0, 1, 0, 1}, {2, 1, 1, 3}},
                                 .spacedim = 2,
                                 .of_mu = 1,
                                 .of_q = 2,
                                 .mu = {0.5},
                                 .q = {-1, 0.25}};

static void write_local(const local_file *s, const char *root)
{
  char name[64];
  hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  snprintf(name, sizeof name, "%s/spacedim", root);
  put_ints(file, name, 1, &s->spacedim);
  snprintf(name, sizeof name, "%s/vectors/mu", root);
  put_reals(file, name, s->of_mu, s->mu);
  snprintf(name, sizeof name, "%s/vectors/q", root);
  put_reals(file, name, s->of_q, s->q);
  snprintf(name, sizeof name, "%s/W", root);
  put_matrix(file, name, &s->W);
  H5Fclose(file);
}

static void reads_as(const local_file *s, const double *W)
{
  nsdae_friction_file file;
  nsdae_error error;
  write_local(s, "/fclib_local");
  int status = nsdae_friction_read(path, &file, &error);
  if (status < 0) fail_msg("%s", error.text);
  assert_int_equal(file.problem.contacts, 1);
  assert_int_equal(file.problem.rows[0], 2);
  assert_int_equal(file.problem.first[1], 1);
  same_reals(4, W, file.problem.value);
  same_reals(2, s->q, file.problem.w);
  nsdae_friction_file_release(&file);
}

/* Columns, rows and triplets; parts of an entry are added; an unsymmetric W is (W + W^T) / 2. */
static void test_forms(void **state)
{
  (void)state;
  const double W[4] = {2, 1, 1, 3};
  local_file s = right;
  reads_as(&s, W);
  s.W.nz = -2;
  reads_as(&s, W);
  s.W = (sparse){2, 2, 5, 5, 5, {1, 0, 0, 1, 0}, {0, 1, 0, 1, 0}, {1, 1, 1.5, 3, 0.5}};
  reads_as(&s, W);
  s.W.nz = 4; /* the last is not used: W_00 = 1.5 */
  reads_as(&s, (double[]){1.5, 1, 1, 3});
  nsdae_friction_file file;
  s = right;
  s.W.x[1] = 1.5; /* W_10 */
  reads_as(&s, (double[]){2, 1.25, 1.25, 3});
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  assert_near(file.asymmetry, 0.5 / 3, 1e-16);
  nsdae_friction_file_release(&file);
  s.W.x[1] = 1e-10; /* beside W_01 a rounding of the diagonal is none of its own */
  s.W.x[2] = 1e-10 + 1e-14;
  write_local(&s, "/fclib_local");
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  assert_true(file.asymmetry == 0);
  nsdae_friction_file_release(&file);
}

static void refused(const char *words)
{
  nsdae_friction_file file = {.tol = 7};
  nsdae_error error;
  int status = nsdae_friction_read(path, &file, &error);
  if (status != NSDAE_E_IO) fail_msg("%d where '%s' is to be refused", status, words);
  assert_int_equal(error.status, NSDAE_E_IO);
  if (!strstr(error.text, words)) fail_msg("'%s' is not in: %s", words, error.text);
  assert_null(strchr(error.text, '\n'));
  assert_true(file.problem.value == NULL && file.tol == 0);
  assert_int_equal(nsdae_friction_read(path, &file, NULL), status);
}

static void refused_local(const local_file *s, const char *words)
{
  write_local(s, "/fclib_local");
  refused(words);
}

/* Solutions in two parts. */

/* The second part stands beside the first: of the contacts at r_low, of the bilateral rows at
 * l_low, zeros where a contact has fewer rows than others. A file without either has none. */
static void test_places_of_two_parts(void **state)
{
  (void)state;
  mixed s;
  nsdae_friction_file file;
  const double r[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  const double low[8] = {1e-17, 2e-17, 3e-17, 4e-17, 5e-17, 6e-17, 7e-17, 8e-17};
  const double wanted[9] = {1e-17, 2e-17, 3e-17, 4e-17, 5e-17, 0, 6e-17, 0, 0};
  double got[9], got_l[2];
  nsdae_friction_points points = {.r = r, .low = low};
  make_mixed(&s);
  assert_int_equal(nsdae_friction_write(path, &s.problem, &points, NULL, NULL), NSDAE_OK);
  take_reals("/solution/r_low", 9, got);
  take_reals("/solution/l_low", 2, got_l);
  same_reals(9, wanted, got);
  same_reals(2, low + 6, got_l);
  hid_t h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(h5, "/solution/l_low", H5P_DEFAULT);
  H5Fclose(h5);
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  same_reals(8, (double[]){1e-17, 2e-17, 3e-17, 4e-17, 5e-17, 6e-17, 0, 0}, file.low);
  nsdae_friction_file_release(&file);
  points = (nsdae_friction_points){.r = r};
  assert_int_equal(nsdae_friction_write(path, &s.problem, &points, NULL, NULL), NSDAE_OK);
  assert_true(has("/solution/r") && !has("/solution/r_low") && !has("/solution/l_low"));
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  assert_true(file.r && !file.low);
  nsdae_friction_file_release(&file);
}

/* A second part without the first is none; one of another length is refused. */
static void test_second_part_alone(void **state)
{
  (void)state;
  mixed s;
  nsdae_friction_file file;
  const double r[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  nsdae_friction_points points = {.low = r};
  make_mixed(&s);
  assert_int_equal(nsdae_friction_write(path, &s.problem, &points, NULL, NULL), NSDAE_OK);
  assert_true(!has("/solution/r_low"));
  hid_t h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  put_reals(h5, "/solution/r_low", 8, r);
  H5Fclose(h5);
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  assert_true(!file.r && !file.low);
  nsdae_friction_file_release(&file);
  points = (nsdae_friction_points){.r = r};
  assert_int_equal(nsdae_friction_write(path, &s.problem, &points, NULL, NULL), NSDAE_OK);
  h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  put_reals(h5, "/solution/r_low", 8, r);
  H5Fclose(h5);
  refused("/solution/r_low has 8 numbers, must be 9");
}

/* The velocities of a solution in two parts: a body of 3e-7 between the ground and one of 1, at
 * rest. By r alone it would move at 1e-11 of the velocity that its weight gives it, 0.1. */
static void test_velocities_of_two_parts(void **state)
{
  (void)state;
  const int size[] = {1, 1}, rows[] = {1, 1}, first[] = {0, 1, 3}, block[] = {0, 0, 1};
  const double M[] = {3e-7, 1}, f[] = {-3e-8, -0.1}, w[] = {0, 0}, mu[] = {0, 0};
  const double value[] = {1, -1, 1};
  const nsdae_friction_problem p = {.contacts = 2,
                                    .rows = rows,
                                    .mu = mu,
                                    .w = w,
                                    .blocks = 2,
                                    .size = size,
                                    .M = M,
                                    .f = f,
                                    .first = first,
                                    .block = block,
                                    .value = value};
  nsdae_friction_options options;
  double r[2] = {0}, low[2] = {0}, u[2], v[2], single;
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  assert_int_equal(nsdae_friction_solve_twice(&p, &options, r, low, u, NULL), NSDAE_OK);
  const nsdae_friction_points points = {.r = r, .u = u, .low = low};
  assert_int_equal(nsdae_friction_write(path, &p, &points, NULL, NULL), NSDAE_OK);
  take_reals("/solution/v", 2, v);
  assert_at_most(fabs(v[0]), 1e-13);
  assert_at_most(fabs(v[1]), 1e-13);
  assert_at_most(fabs(v[0] - u[0]), 1e-16);
  const nsdae_friction_points alone = {.r = r, .u = u};
  assert_int_equal(nsdae_friction_write(path, &p, &alone, NULL, NULL), NSDAE_OK);
  take_reals("/solution/v", 2, v);
  assert_true(fabs(v[0]) > 1e-12);
  assert_int_equal(nsdae_friction_residual(&p, r, NULL, &single), NSDAE_OK);
  assert_true(single > 1e-12);
}

static void test_refused_matrices(void **state)
{
  (void)state;
  local_file s = right;
  s.W.x[2] = NAN;
  refused_local(&s, "fclib_local/W/x[2] is nan, must be finite");
  s = right;
  s.W.i[3] = 2;
  refused_local(&s, "entry 3 is at (2, 1) of 2 x 2");
  s.W.i[3] = -1;
  refused_local(&s, "entry 3 is at (-1, 1) of 2 x 2");
  s = right;
  s.W.p[1] = 5;
  refused_local(&s, "W/p[2] = 4 is below p[1] = 5");
  s.W.p[2] = 6;
  refused_local(&s, "has 6 entries, but 4 indices and values");
  s.W.p[2] = INT_MAX; /* nothing of that size is allocated or filled */
  refused_local(&s, "has 2147483647 entries, but 4 indices and values");
  s = right;
  s.W.p[0] = 1;
  refused_local(&s, "p[0] is 1, must be 0");
  s = right;
  s.W.of_p = 2;
  refused_local(&s, "W/p has 2 numbers, must be 3");
  s = right;
  s.W.m = 3;
  refused_local(&s, "W is 3 x 2, must be 2 x 2");
  s.W.m = -2;
  refused_local(&s, "W/m is -2");
  s = right;
  s.W.nz = -3;
  refused_local(&s, "W/nz is -3");
  s.W.nz = 2000000000;
  refused_local(&s, "has 2000000000 entries");
}

static void test_refused_vectors(void **state)
{
  (void)state;
  local_file s = right;
  s.q[1] = INFINITY;
  refused_local(&s, "vectors/q[1] is inf, must be finite");
  s = right;
  s.of_q = 3;
  refused_local(&s, "vectors/q has 3 numbers, must be 2");
  s = right;
  s.mu[0] = -0.5;
  refused_local(&s, "mu[0] is -0.5, must not be negative");
  s = right;
  s.of_mu = 2;
  refused_local(&s, "W is 2 x 2, must be 4 x 4");
  s = right;
  s.spacedim = 5;
  refused_local(&s, "spacedim is 5, must be 2 or 3");
  write_local(&right, "/fclib_local_rolling");
  refused("rolling friction (dimension 5)");
  write_local(&right, "/somewhere");
  refused("neither /fclib_local nor /fclib_global");
  write_local(&right, "/fclib_local");
  hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "/fclib_local/vectors/q", H5P_DEFAULT);
  H5Fclose(file);
  refused("/fclib_local/vectors/q is missing");
  file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  put_reals(file, "/fclib_global/vectors/q", 1, (double[]){1});
  H5Fclose(file);
  refused("both /fclib_local and /fclib_global");
}

/* A block of M that only a long chain of entries joins: 3000 freedoms in 6000 entries. */
static void test_refused_block(void **state)
{
  (void)state;
  enum { N = 3000 };
  static int p[2 * N], i[2 * N];
  static double x[2 * N], f[N];
  const int one = 1, n = N, count = 2 * N - 1, nothing = 0, dim = 3;
  for (int k = 0; k < N; k++) {
    p[2 * k] = i[2 * k] = k;
    x[2 * k] = 1;
    p[2 * k + 1] = k;
    i[2 * k + 1] = k + 1;
    x[2 * k + 1] = 0.1;
  }
  hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  put_ints(file, "/fclib_global/spacedim", 1, &dim);
  put_reals(file, "/fclib_global/vectors/mu", 0, f);
  put_reals(file, "/fclib_global/vectors/w", 0, f);
  put_reals(file, "/fclib_global/vectors/f", N, f);
  static const char *const matrix[] = {"/fclib_global/M", "/fclib_global/H"};
  for (int k = 0; k < 2; k++) {
    char name[64];
    const int *const sizes[] = {&n, k == 0 ? &n : &nothing, k == 0 ? &count : &nothing};
    static const char *const names[] = {"m", "n", "nz"};
    for (int e = 0; e < 3; e++) {
      snprintf(name, sizeof name, "%s/%s", matrix[k], names[e]);
      put_ints(file, name, one, sizes[e]);
    }
    snprintf(name, sizeof name, "%s/p", matrix[k]);
    put_ints(file, name, k == 0 ? count : 0, p);
    snprintf(name, sizeof name, "%s/i", matrix[k]);
    put_ints(file, name, k == 0 ? count : 0, i);
    snprintf(name, sizeof name, "%s/x", matrix[k]);
    put_reals(file, name, k == 0 ? count : 0, x);
  }
  H5Fclose(file);
  refused("its blocks would take 9e+06 numbers");
}

/* Freedoms that M joins without standing side by side are put side by side. */
static void test_order_of_velocities(void **state)
{
  (void)state;
  const sparse M = {3, 3, 5, 5, 5, {0, 1, 2, 0, 2}, {0, 1, 2, 2, 0}, {2, 3, 4, 1, 1}};
  const sparse H = {3, 2, -1, 3, 3, {0, 2, 3}, {0, 1, 2}, {1, 5, -1}};
  const int dim = 2;
  hid_t h5 = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  put_ints(h5, "/fclib_global/spacedim", 1, &dim);
  put_reals(h5, "/fclib_global/vectors/mu", 1, (double[]){0.5});
  put_reals(h5, "/fclib_global/vectors/w", 2, (double[]){0, 0});
  put_reals(h5, "/fclib_global/vectors/f", 3, (double[]){7, 8, 9});
  put_matrix(h5, "/fclib_global/M", &M);
  put_matrix(h5, "/fclib_global/H", &H);
  H5Fclose(h5);
  nsdae_friction_file file;
  nsdae_error error;
  int status = nsdae_friction_read(path, &file, &error);
  if (status < 0) fail_msg("%s", error.text);
  /* three planar freedoms are one block as they stand */
  same_ints(1, (int[]){3}, file.problem.size);
  same_reals(9, (double[]){2, 0, 1, 0, 3, 0, 1, 0, 4}, file.problem.M);
  nsdae_friction_file_release(&file);
  h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  put_ints(h5, "/fclib_global/blocks", 2, (int[]){2, 1});
  H5Fclose(h5);
  refused("joins two blocks");
}

static void test_order_of_found_blocks(void **state)
{
  (void)state;
  const sparse M = {4, 4, 6, 6, 6, {0, 1, 2, 3, 0, 2}, {0, 1, 2, 3, 2, 0}, {2, 3, 4, 6, 1, 1}};
  const sparse H = {4, 2, -1, 3, 3, {0, 2, 3}, {0, 1, 2}, {1, 5, -1}};
  const int dim = 2;
  hid_t h5 = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  put_ints(h5, "/fclib_global/spacedim", 1, &dim);
  put_reals(h5, "/fclib_global/vectors/mu", 1, (double[]){0.5});
  put_reals(h5, "/fclib_global/vectors/w", 2, (double[]){0, 0});
  put_reals(h5, "/fclib_global/vectors/f", 4, (double[]){7, 8, 9, 10});
  put_matrix(h5, "/fclib_global/M", &M);
  put_matrix(h5, "/fclib_global/H", &H);
  H5Fclose(h5);
  nsdae_friction_file file;
  assert_int_equal(nsdae_friction_read(path, &file, NULL), NSDAE_OK);
  assert_int_equal(file.problem.blocks, 3);
  same_ints(3, (int[]){2, 1, 1}, file.problem.size);
  same_ints(4, (int[]){0, 2, 1, 3}, file.velocity);
  same_reals(4, (double[]){7, 9, 8, 10}, file.problem.f);
  same_reals(6, (double[]){2, 1, 1, 4, 3, 6}, file.problem.M);
  /* the first column of H is at 0 and 1, the second at 2: blocks 0 and 1 */
  same_ints(2, (int[]){0, 1}, file.problem.block);
  same_reals(6, (double[]){1, 0, 0, -1, 5, 0}, file.problem.value);
  nsdae_friction_file_release(&file);
}

static void test_arguments(void **state)
{
  (void)state;
  mixed s;
  nsdae_friction_file file;
  nsdae_error error;
  make_mixed(&s);
  assert_int_equal(nsdae_friction_read(NULL, &file, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "path");
  assert_int_equal(nsdae_friction_read(path, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_write(NULL, &s.problem, NULL, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_write(path, NULL, NULL, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_write("/nonexistent/x.h5", &s.problem, NULL, NULL, &error),
                   NSDAE_E_IO);
  s.mu[0] = -1;
  assert_int_equal(nsdae_friction_write(path, &s.problem, NULL, NULL, &error), NSDAE_E_ARGUMENT);
  nsdae_friction_file_release(NULL);
}

/* Seeded damage: bytes changed, ranges overwritten, the end cut off. Whatever comes, it is a status
 * with a text, or a problem that a check can look at. */
static void test_corrupt(void **state)
{
  (void)state;
  friction_sample s;
  friction_sample_draw(&s, FRICTION_WALL, 20, 3);
  assert_int_equal(nsdae_friction_write(path, &s.problem, NULL, NULL, NULL), NSDAE_OK);
  friction_sample_release(&s);
  FILE *stream = fopen(path, "rb");
  fseek(stream, 0, SEEK_END);
  size_t length = (size_t)ftell(stream);
  unsigned char *kept = malloc(length), *bytes = malloc(length);
  rewind(stream);
  assert_int_equal(fread(kept, 1, length, stream), length);
  fclose(stream);
  const char *more = getenv("NSDAE_TEST_CORRUPT");
  int count = more ? atoi(more) : 400, refusals = 0;
  srand(1);
  for (int k = 0; k < count; k++) {
    nsdae_friction_file file;
    nsdae_error error;
    size_t end = k % 5 == 4 ? (size_t)rand() % length : length;
    memcpy(bytes, kept, length);
    size_t within = k % 2 ? length : length < 20000 ? length : 20000; /* where the structure is */
    for (int e = 0; e <= rand() % 8; e++) bytes[(size_t)rand() % within] = (unsigned char)rand();
    stream = fopen(path, "wb");
    fwrite(bytes, 1, end, stream);
    fclose(stream);
    int status = nsdae_friction_read(path, &file, &error);
    assert_true(status <= 0 && status == error.status);
    if (status < 0) {
      refusals++;
      assert_true(strlen(error.text) > 10);
    } else
      nsdae_friction_check(&file.problem, &error);
    nsdae_friction_file_release(&file);
  }
  assert_true(refusals > count / 5);
  free(kept);
  free(bytes);
}

int main(void)
{
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_there_and_back),
      cmocka_unit_test(test_mixed),
      cmocka_unit_test(test_forms),
      cmocka_unit_test(test_places_of_two_parts),
      cmocka_unit_test(test_second_part_alone),
      cmocka_unit_test(test_velocities_of_two_parts),
      cmocka_unit_test(test_refused_matrices),
      cmocka_unit_test(test_refused_vectors),
      cmocka_unit_test(test_refused_block),
      cmocka_unit_test(test_order_of_velocities),
      cmocka_unit_test(test_order_of_found_blocks),
      cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_corrupt),
  };
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  unlink(path);
  return failed;
}
