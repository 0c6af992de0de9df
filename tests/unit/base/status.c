/* Statuses and the error record. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "errors.h"

static const int values[] = {
#define VALUE(name, value, message) name,
    NSDAE_STATUS_LIST(VALUE)
#undef VALUE
};

enum { COUNT = sizeof values / sizeof *values };

static void test_all_differ(void **state)
{
  (void)state;
  for (int i = 0; i < COUNT; i++)
    for (int j = 0; j < i; j++) {
      assert_int_not_equal(values[i], values[j]);
      assert_string_not_equal(nsdae_status_name(values[i]), nsdae_status_name(values[j]));
      assert_string_not_equal(nsdae_status_message(values[i]), nsdae_status_message(values[j]));
    }
}

/* 0 done, < 0 not done, > 0 done and something to know: the names say which. */
static void test_signs(void **state)
{
  (void)state;
  assert_int_equal(NSDAE_OK, 0);
  for (int i = 0; i < COUNT; i++) {
    const char *name = nsdae_status_name(values[i]);
    assert_int_equal(strncmp(name, "NSDAE_", 6), 0);
    assert_int_equal(strncmp(name, "NSDAE_E_", 8) == 0, values[i] < 0);
    assert_true(*nsdae_status_message(values[i]) != '\0');
    assert_null(strchr(nsdae_status_message(values[i]), '\n'));
  }
  assert_string_equal(nsdae_status_name(NSDAE_E_RANK), "NSDAE_E_RANK");
}

static void test_unknown(void **state)
{
  (void)state;
  const int unknown[] = {99, 1000, -100, -2147483647 - 1};
  for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
    assert_string_equal(nsdae_status_name(unknown[i]), "unknown status");
    assert_string_equal(nsdae_status_message(unknown[i]), "unknown status");
  }
}

static void test_clear(void **state)
{
  (void)state;
  nsdae_error error;
  memset(&error, 0x5a, sizeof error);
  nsdae_error_clear(&error);
  assert_int_equal(error.status, NSDAE_OK);
  assert_int_equal(error.code, 0);
  assert_int_equal(error.index, -1);
  assert_true(isnan(error.time));
  assert_string_equal(error.argument, "");
  assert_string_equal(error.where, "");
  assert_string_equal(error.text, "");
  nsdae_error_clear(NULL);
}

static void test_set(void **state)
{
  (void)state;
  nsdae_error error;
  memset(&error, 0x5a, sizeof error);
  int status = nsdae_error_set(&error, NSDAE_E_IO, "here", "this", "%s = %d", "x", 3);
  assert_int_equal(status, NSDAE_E_IO);
  assert_int_equal(error.status, NSDAE_E_IO);
  assert_int_equal(error.code, 0);
  assert_int_equal(error.index, -1);
  assert_true(isnan(error.time));
  assert_string_equal(error.where, "here");
  assert_string_equal(error.argument, "this");
  assert_string_equal(error.text, "x = 3");
  assert_int_equal(nsdae_error_set(NULL, NSDAE_E_IO, "here", "", "text"), NSDAE_E_IO);
}

static void test_one_line(void **state)
{
  (void)state;
  nsdae_error error;
  nsdae_error_set(&error, NSDAE_E_IO, "here", "", "a\nb\r\nc\td%s", "\n");
  assert_string_equal(error.text, "a b  c d ");
}

static void test_truncation(void **state)
{
  (void)state;
  char word[1000];
  nsdae_error error;
  memset(word, 'w', sizeof word - 1);
  word[sizeof word - 1] = '\0';
  nsdae_error_set(&error, NSDAE_E_IO, word, word, "%s", word);
  assert_int_equal(strlen(error.where), sizeof error.where - 1);
  assert_int_equal(strlen(error.argument), sizeof error.argument - 1);
  assert_int_equal(strlen(error.text), sizeof error.text - 1);
}

/* All texts are one line, also those that come from a user's key. */
static void test_one_line_everywhere(void **state)
{
  (void)state;
  nsdae_error error;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  assert_int_equal(nsdae_sim_options_set(&options, "d\nt", "1\n", &error), NSDAE_E_OPTION);
  assert_null(strpbrk(error.text, "\n\r"));
  assert_null(strpbrk(error.argument, "\n\r"));
  assert_null(strpbrk(error.where, "\n\r"));
}

static void test_version(void **state)
{
  (void)state;
  char made[32];
  snprintf(made, sizeof made, "%d.%d.%d", NSDAE_VERSION_MAJOR, NSDAE_VERSION_MINOR,
           NSDAE_VERSION_PATCH);
  assert_string_equal(nsdae_version(), made);
  assert_string_equal(nsdae_version(), NSDAE_VERSION);
  assert_true(strlen(nsdae_build_info()) > 0);
  assert_null(strchr(nsdae_build_info(), '\n'));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_all_differ), cmocka_unit_test(test_signs),
      cmocka_unit_test(test_unknown),    cmocka_unit_test(test_clear),
      cmocka_unit_test(test_set),        cmocka_unit_test(test_one_line),
      cmocka_unit_test(test_truncation), cmocka_unit_test(test_one_line_everywhere),
      cmocka_unit_test(test_version),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
