/* The nearest name that is offered for an unknown one. */
#include "check.h"

#include <nsdae/params.h>

static const char *const names[] = {"dt", "method", "contact_tol", "rank_tol", "polygon", NULL};

static void offers(const char *word, const char *name)
{
  const char *got = nsdae_suggest_name(word, names);
  if (!name) {
    if (got) fail_msg("'%s' offers '%s'", word, got);
    return;
  }
  if (!got) fail_msg("'%s' offers nothing", word);
  assert_string_equal(got, name);
}

static void test_one_letter(void **state)
{
  (void)state;
  offers("methd", "method");   /* left out */
  offers("methood", "method"); /* put in */
  offers("mathod", "method");  /* changed */
  offers("mehtod", "method");  /* exchanged: two changes */
  offers("polygons", "polygon");
  offers("contact-tol", "contact_tol");
  offers("rank_toll", "rank_tol");
}

static void test_exact(void **state)
{
  (void)state;
  for (int i = 0; names[i]; i++) offers(names[i], names[i]);
}

/* More than half of the word's letters would change. */
static void test_too_far(void **state)
{
  (void)state;
  offers("zzzzzz", NULL);
  offers("", NULL);
  offers("energy_balance", NULL);
}

static void test_no_names(void **state)
{
  (void)state;
  const char *const none[] = {NULL};
  assert_null(nsdae_suggest_name("word", none));
  assert_null(nsdae_suggest_name("", none));
}

/* Longer than the row of the distance: compared by their beginnings. */
static void test_long(void **state)
{
  (void)state;
  char word[300];
  memset(word, 'p', sizeof word - 1);
  word[sizeof word - 1] = '\0';
  nsdae_suggest_name(word, names);
  const char *const same[] = {word, NULL};
  assert_ptr_equal(nsdae_suggest_name(word, same), word);
}

/* Options: their dashes are no likeness, and a beginning is nearer than a short word. */
static void test_options(void **state)
{
  (void)state;
  const char *const options[] = {"--dt", "--t-end", "--set", "--output", "--method", NULL};
  assert_null(nsdae_suggest_name("--foo", options));
  assert_null(nsdae_suggest_name("--", options));
  assert_null(nsdae_suggest_name("--x", options));
  assert_string_equal(nsdae_suggest_name("--out", options), "--output");
  assert_string_equal(nsdae_suggest_name("--meth", options), "--method");
  assert_string_equal(nsdae_suggest_name("-dt", options), "--dt");
  assert_string_equal(nsdae_suggest_name("--t_end", options), "--t-end");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_one_letter), cmocka_unit_test(test_exact),
      cmocka_unit_test(test_too_far),    cmocka_unit_test(test_no_names),
      cmocka_unit_test(test_long),       cmocka_unit_test(test_options),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
