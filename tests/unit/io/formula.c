/* The reader of formulas: what belongs to the language, what does not and where that is said, and
 * words of random symbols against a reader of another kind (a table of what may follow what). */
#include "formula.h"

#include <stdlib.h>

#include "check.h"
#include "support/random.h"

typedef struct {
  double L, m_2;
  int n;
  char text[NSDAE_PARAM_TEXT_SIZE];
} model;

static const nsdae_param entries[] = {
    {"L", "m", "", NSDAE_PARAM_REAL, offsetof(model, L), 1, 0, 2, 0, NULL},
    {"m_2", "kg", "", NSDAE_PARAM_REAL, offsetof(model, m_2), 1, 0, 2, 0, NULL},
    {"n", "1", "", NSDAE_PARAM_INT, offsetof(model, n), 1, 0, 2, 0, NULL},
    {"name", "", "", NSDAE_PARAM_TEXT, offsetof(model, text), 0, 0, 0, 0, NULL},
};
static const nsdae_params parameters = {entries, 4};
static const nsdae_named coordinates[] = {{"theta", 2}, {"x", 0}};
static const nsdae_formula_names names = {3, 2, coordinates, &parameters};
static const nsdae_formula_names bare = {2, 0, NULL, NULL};

static int accepted(const char *text)
{
  char reason[NSDAE_FORMULA_REASON];
  int status = nsdae_formula_check(text, &names, reason);
  assert_true((status == NSDAE_OK) == (reason[0] == '\0'));
  assert_true(status == NSDAE_OK || status == NSDAE_E_ARGUMENT);
  return status == NSDAE_OK;
}

static void refused(const char *text, const char *why)
{
  char reason[NSDAE_FORMULA_REASON];
  assert_int_equal(nsdae_formula_check(text, &names, reason), NSDAE_E_ARGUMENT);
  if (strcmp(reason, why) != 0) print_error("'%s': %s\n", text, reason);
  assert_string_equal(reason, why);
}

static void takes_the_language(void **state)
{
  static const char *const good[] = {"0",
                                     "q0",
                                     "q2",
                                     "x",
                                     "theta",
                                     "L*sin(q0)",
                                     "-L * cos( theta ) / 2",
                                     "1.5e-3",
                                     ".5",
                                     "2.",
                                     "1E+3",
                                     "--q1",
                                     "q0^2^3",
                                     "2^-1",
                                     "q0^2/(2*L)",
                                     "atan2(q1, q0)",
                                     "hypot(min(1,2),max(n,pi))",
                                     "sqrt(abs(m_2))*exp(-t)*log(2)",
                                     "((((q0))))",
                                     " q0 ",
                                     "tan(asin(acos(atan(0))))"};
  (void)state;
  for (size_t i = 0; i < sizeof good / sizeof *good; i++)
    if (!accepted(good[i])) fail_msg("'%s' is refused", good[i]);
}

static void says_what_is_wrong_and_where(void **state)
{
  (void)state;
  refused("", "the formula ends in place of a value, at character 1");
  refused("q0+", "the formula ends in place of a value, at character 4");
  refused("q3", "there is no q3: the coordinates are q0 to q2, at character 1");
  refused("q99999999999", "there is no q99999999999: the coordinates are q0 to q2, at character 1");
  refused("L*thet", "unknown name 'thet' (did you mean 'theta'?) at character 3");
  refused("bogus_one", "unknown name 'bogus_one' at character 1");
  refused("name", "unknown name 'name' at character 1"); /* a text */
  refused("sin q0", "sin without ( at character 5");
  refused("sin(q0", "sin without ) at character 7");
  refused("sin(q0,q1)", "sin without ) at character 7");
  refused("atan2(q0)", "atan2 takes 2 values, at character 9");
  refused("(q0", "( without ) at character 4");
  refused("q0)", "')' is not expected at character 3");
  refused("2 q0", "'q' is not expected at character 3");
  refused("q0 q1", "'q' is not expected at character 4");
  refused("*q0", "'*' in place of a value at character 1");
  refused("q0**2", "'*' in place of a value at character 4");
  refused(".", "a point without digits at character 2");
  refused("1e", "an exponent without digits at character 3");
  refused("q0;1", "';' is not expected at character 3");
}

static void knows_no_other_names(void **state)
{
  char reason[NSDAE_FORMULA_REASON];
  (void)state;
  assert_int_equal(nsdae_formula_check("q1+t+pi", &bare, reason), NSDAE_OK);
  assert_int_equal(nsdae_formula_check("L", &bare, reason), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_formula_check("theta", &bare, reason), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_formula_check("q2", &bare, reason), NSDAE_E_ARGUMENT);
}

static void refuses_what_is_too_long(void **state)
{
  char text[NSDAE_FORMULA_LENGTH + 1];
  (void)state;
  memset(text, '(', sizeof text);
  text[NSDAE_FORMULA_LENGTH] = '\0';
  assert_false(accepted(text));
  memset(text, '1', sizeof text);
  text[NSDAE_FORMULA_LENGTH] = '\0';
  assert_false(accepted(text));
  text[NSDAE_FORMULA_LENGTH - 1] = '\0';
  assert_true(accepted(text));
}

/* Symbols of the language without functions: v a value, s a sign, o another operator. What begins
 * or follows an operator, a sign or '(' is a value, a sign or '('; what follows a value or ')' is
 * an operator, a sign or ')'; the brackets balance: no reader of grammars is needed to tell. */
static int well_formed(const char *kinds, int n)
{
  int value_next = 1, open = 0;
  for (int i = 0; i < n; i++) {
    char k = kinds[i];
    if (value_next != (k == 'v' || k == '(') && k != 's') return 0;
    open += (k == '(') - (k == ')');
    if (open < 0) return 0;
    value_next = k == 's' || k == 'o' || k == '(';
  }
  return open == 0 && !value_next;
}

static void agrees_with_another_reader(void **state)
{
  static const struct {
    const char *text;
    char kind;
  } symbols[] = {{"q1", 'v'}, {"2.5", 'v'}, {"L", 'v'}, {"+", 's'}, {"-", 's'},
                 {"*", 'o'},  {"/", 'o'},   {"^", 'o'}, {"(", '('}, {")", ')'}};
  uint64_t seed = 12345;
  int good = 0;
  (void)state;
  for (int word = 0; word < 200000; word++) {
    char text[64] = "", kinds[8];
    int n = 1 + word % 8;
    for (int i = 0; i < n; i++) {
      int s = random_below(&seed, 10);
      kinds[i] = symbols[s].kind;
      strcat(strcat(text, symbols[s].text), " "); /* blanks: "2.5" "2.5" is not "2.52.5" */
    }
    good += well_formed(kinds, n);
    if (accepted(text) != well_formed(kinds, n)) fail_msg("'%s'", text);
  }
  assert_true(good > 5000);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(takes_the_language),         cmocka_unit_test(says_what_is_wrong_and_where),
      cmocka_unit_test(knows_no_other_names),       cmocka_unit_test(refuses_what_is_too_long),
      cmocka_unit_test(agrees_with_another_reader),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
