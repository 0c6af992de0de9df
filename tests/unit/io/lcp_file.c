/* Complementarity problems in HDF5: there and back, in the order of NumPy, and what is refused. */
#include "check.h"

#include <hdf5.h>
#include <nsdae/nsdae.h>
#include <unistd.h>

#include "allocator.h"

static const char *const path = "test_lcp_file.h5";

static void refused(int status, const char *words)
{
  nsdae_lcp_file file = {.n = 7};
  nsdae_error error;
  assert_int_equal(nsdae_lcp_read(path, &file, &error), status);
  assert_int_equal(error.status, status);
  if (!strstr(error.text, words)) fail_msg("'%s' is not in: %s", words, error.text);
  assert_null(strchr(error.text, '\n'));
  assert_null(file.A);
  assert_int_equal(file.n, 0);
  assert_int_equal(nsdae_lcp_read(path, &file, NULL), status);
}

/* A is a part of a larger array and not symmetric; [i, j] in the file is A(i, j). */
static void test_there_and_back(void **state)
{
  (void)state;
  enum { N = 3, LDA = 5 };
  double A[N * LDA], b[N] = {-1, 1e-300, 3};
  for (int j = 0; j < N; j++)
    for (int i = 0; i < LDA; i++) A[j * LDA + i] = i < N ? 10.0 * (i + 1) + j + 1 : (double)NAN;
  const nsdae_lcp_problem problem = {.n = N, .A = A, .lda = LDA, .b = b};
  const nsdae_lcp_origin origin = {.time = 0.25, .step = 50, .tol = 1e-9, .method = "moreau"};
  nsdae_lcp_file file;
  nsdae_error error;
  assert_int_equal(nsdae_lcp_write(path, &problem, &origin, &error), NSDAE_OK);
  assert_int_equal(nsdae_lcp_read(path, &file, &error), NSDAE_OK);
  assert_int_equal(file.n, N);
  assert_true(file.tol == 1e-9);
  for (int j = 0; j < N; j++) {
    assert_true(file.b[j] == b[j]);
    for (int i = 0; i < N; i++) assert_true(file.A[j * N + i] == A[j * LDA + i]);
  }
  nsdae_lcp_file_release(&file);
  assert_null(file.A);
  nsdae_lcp_file_release(NULL);
  double rows[N][N];
  hid_t h5 = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen2(h5, "A", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows) >= 0);
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++) assert_true(rows[i][j] == 10 * (i + 1) + j + 1);
  H5Dclose(set);
  H5Fclose(h5);
}

static void test_empty(void **state)
{
  (void)state;
  const nsdae_lcp_problem problem = {.n = 0, .lda = 1};
  nsdae_lcp_file file;
  assert_int_equal(nsdae_lcp_write(path, &problem, NULL, NULL), NSDAE_OK);
  assert_int_equal(nsdae_lcp_read(path, &file, NULL), NSDAE_OK);
  assert_int_equal(file.n, 0);
  assert_true(file.tol == 0);
  nsdae_lcp_file_release(&file);
}

static void test_arguments(void **state)
{
  (void)state;
  const double one = 1;
  const nsdae_lcp_problem good = {1, &one, 1, &one},
                          bad[] = {{-1, &one, 1, &one}, {1, NULL, 1, &one},
                                   {1, &one, 0, &one},  {1, &one, 1, NULL},
                                   {0, NULL, 0, NULL},  {30000, &one, 30000, &one}};
  nsdae_lcp_file file;
  nsdae_error error;
  assert_int_equal(nsdae_lcp_write(NULL, &good, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "path");
  assert_int_equal(nsdae_lcp_write(path, NULL, NULL, NULL), NSDAE_E_ARGUMENT);
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    assert_int_equal(nsdae_lcp_write(path, &bad[i], NULL, &error), NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, "problem");
  }
  assert_int_equal(nsdae_lcp_read(NULL, &file, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_lcp_read(path, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_lcp_write("no/such/folder/x.h5", &good, NULL, &error), NSDAE_E_IO);
  assert_non_null(strstr(error.text, "No such file or directory"));
  assert_int_equal(nsdae_lcp_write("/dev/full", &good, NULL, &error), NSDAE_E_IO);
}

/* A file with datasets of those shapes, whose space is in it; rank < 0: none. */
static void make(int rank_a, const hsize_t *a, int rank_b, const hsize_t *b, hid_t type)
{
  hid_t taken = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_alloc_time(taken, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(taken, H5D_FILL_TIME_NEVER);
  hid_t h5 = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  for (int i = 0; i < 2; i++) {
    int rank = i ? rank_b : rank_a;
    if (rank < 0) continue;
    hid_t space = H5Screate_simple(rank, i ? b : a, NULL);
    H5Dclose(H5Dcreate2(h5, i ? "b" : "A", type, space, H5P_DEFAULT, taken, H5P_DEFAULT));
    H5Sclose(space);
  }
  H5Pclose(taken);
  H5Fclose(h5);
}

static void test_shapes(void **state)
{
  (void)state;
  const hsize_t two[3] = {2, 2, 2}, uneven[2] = {2, 3}, large[2] = {20001, 20001};
  nsdae_lcp_file file;
  make(2, two, 1, two, H5T_NATIVE_FLOAT); /* floats and integers are numbers */
  assert_int_equal(nsdae_lcp_read(path, &file, NULL), NSDAE_OK);
  nsdae_lcp_file_release(&file);
  make(2, two, 1, two, H5T_NATIVE_INT);
  assert_int_equal(nsdae_lcp_read(path, &file, NULL), NSDAE_OK);
  nsdae_lcp_file_release(&file);
  make(2, two, 1, two, H5T_C_S1);
  refused(NSDAE_E_IO, path);
  make(-1, NULL, 1, two, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "dataset /A is missing");
  make(2, two, -1, NULL, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "dataset /b is missing");
  make(1, two, 1, two, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "dataset /A is not a matrix");
  make(3, two, 1, two, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "dataset /A is not a matrix");
  make(2, two, 2, two, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "dataset /b is not a vector");
  make(2, uneven, 1, two, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "/A is 2 x 3 and /b has 2 entries");
  make(2, two, 1, uneven + 1, H5T_NATIVE_DOUBLE);
  refused(NSDAE_E_IO, "/A is 2 x 2 and /b has 3 entries");
  make(2, large, 1, large, H5T_NATIVE_UCHAR);
  refused(NSDAE_E_IO, "n <= 20000");
}

/* Every length of a file that was cut off: never read as a problem that it is not. */
static void test_cut_off(void **state)
{
  (void)state;
  const double A[4] = {2, 0, 1, 2}, b[2] = {-5, -6};
  const nsdae_lcp_problem problem = {2, A, 2, b};
  assert_int_equal(nsdae_lcp_write(path, &problem, NULL, NULL), NSDAE_OK);
  FILE *stream = fopen(path, "rb");
  fseek(stream, 0, SEEK_END);
  long size = ftell(stream);
  fclose(stream);
  for (long length = size - 1; length >= 0; length -= 1 + size / 97) {
    assert_int_equal(truncate(path, length), 0);
    refused(NSDAE_E_IO, path);
  }
  remove(path);
  refused(NSDAE_E_IO, "No such file or directory");
}

/* Each allocation of the library in turn fails: said, and nothing is left behind. */
static void test_memory(void **state)
{
  (void)state;
  const double A[4] = {2, 0, 1, 2}, b[2] = {-5, -6};
  const nsdae_lcp_problem problem = {2, A, 2, b};
  nsdae_lcp_file file;
  allocator_reset(0);
  assert_int_equal(nsdae_lcp_write(path, &problem, NULL, NULL), NSDAE_E_MEMORY);
  allocator_reset(-1);
  assert_int_equal(nsdae_lcp_write(path, &problem, NULL, NULL), NSDAE_OK);
  assert_int_equal(the_allocator.live, 0);
  for (int at = 0; at < 3; at++) {
    allocator_reset(at);
    assert_int_equal(nsdae_lcp_read(path, &file, NULL), NSDAE_E_MEMORY);
    assert_null(file.A);
    assert_int_equal(the_allocator.live, 0);
  }
  allocator_reset(3);
  assert_int_equal(nsdae_lcp_read(path, &file, NULL), NSDAE_OK);
  nsdae_lcp_file_release(&file);
  assert_int_equal(the_allocator.live, 0);
  allocator_reset(-1);
  remove(path);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_there_and_back), cmocka_unit_test(test_empty),
      cmocka_unit_test(test_arguments),      cmocka_unit_test(test_shapes),
      cmocka_unit_test(test_cut_off),        cmocka_unit_test(test_memory),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
