/* Parameter tables: defaults, setting from text, ranges, formatting. */
#include "check.h"

#include <float.h>
#include <limits.h>
#include <locale.h>
#include <stdlib.h>

#include <nsdae/params.h>

typedef struct sample {
  double length, angle, fraction, any, bound;
  int count, colour;
  char name[NSDAE_PARAM_TEXT_SIZE];
} sample;

static const char *const colours[] = {"red", "green", "blue", NULL};

#define AT(field) offsetof(sample, field)

static const nsdae_param entries[] = {
    {"length", "m", "", NSDAE_PARAM_REAL, AT(length), 2.5, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"angle", "rad", "half the opening of it", NSDAE_PARAM_REAL, AT(angle), 0.1, -1, 1,
     NSDAE_OPEN_MAX, NULL},
    {"fraction", "1", "", NSDAE_PARAM_REAL, AT(fraction), 0.5, 0, 1,
     NSDAE_OPEN_MIN | NSDAE_OPEN_MAX, NULL},
    {"any", "1", "", NSDAE_PARAM_REAL, AT(any), 0, -INFINITY, INFINITY, 0, NULL},
    {"count", "1", "", NSDAE_PARAM_INT, AT(count), 7, 1, 1000, 0, NULL},
    {"colour", "", "", NSDAE_PARAM_CHOICE, AT(colour), 1, 0, 2, 0, colours},
    {"name", "", "", NSDAE_PARAM_TEXT, AT(name), 0, 0, 0, 0, NULL},
    {"bound", "s", "", NSDAE_PARAM_REAL, AT(bound), INFINITY, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};

static sample filled(void)
{
  sample s;
  memset(&s, 0x5a, sizeof s); /* so that a field that is left out shows */
  nsdae_params_default(&table, &s);
  return s;
}

static void test_defaults(void **state)
{
  (void)state;
  sample s = filled();
  assert_true(s.length == 2.5 && s.angle == 0.1 && s.fraction == 0.5 && s.any == 0);
  assert_int_equal(s.count, 7);
  assert_int_equal(s.colour, 1);
  assert_string_equal(s.name, "");
  assert_int_equal(nsdae_params_check(&table, &s, NULL), NSDAE_OK);
}

static void test_range_in_words(void **state)
{
  (void)state;
  static const char *const words[] = {"greater than 0",
                                      "at least -1 and less than 1",
                                      "greater than 0 and less than 1",
                                      "a finite number",
                                      "at least 1 and at most 1000",
                                      "red, green or blue",
                                      "",
                                      "greater than 0"};
  char text[64];
  for (int i = 0; i < table.n; i++) {
    nsdae_params_range(&entries[i], text, sizeof text);
    assert_string_equal(text, words[i]);
  }
  for (size_t size = 0; size < 20; size++) { /* cut short, never beyond */
    memset(text, 'x', sizeof text);
    nsdae_params_range(&entries[5], text, size);
    assert_true(size == 0 || strlen(text) == (size < 19 ? size - 1 : 18));
    assert_int_equal(text[size < 19 ? size : 19], 'x');
  }
}

static void test_set_each_type(void **state)
{
  (void)state;
  sample s = filled();
  nsdae_error error;
  assert_int_equal(nsdae_params_set(&table, &s, "length", "1.25e-3", &error), NSDAE_OK);
  assert_int_equal(error.status, NSDAE_OK);
  assert_int_equal(nsdae_params_set(&table, &s, "count", "12", &error), NSDAE_OK);
  assert_int_equal(nsdae_params_set(&table, &s, "colour", "blue", &error), NSDAE_OK);
  assert_int_equal(nsdae_params_set(&table, &s, "name", "a b c", &error), NSDAE_OK);
  assert_true(s.length == 1.25e-3);
  assert_int_equal(s.count, 12);
  assert_int_equal(s.colour, 2);
  assert_string_equal(s.name, "a b c");
  assert_int_equal(nsdae_params_set(&table, &s, "bound", "2", NULL), NSDAE_OK);
  assert_true(s.bound == 2);
  assert_int_equal(nsdae_params_set(&table, &s, "bound", "inf", NULL), NSDAE_OK); /* the default */
  assert_true(isinf(s.bound));
  assert_int_equal(nsdae_params_set(&table, &s, "count", "1e2", NULL), NSDAE_OK);
  assert_int_equal(s.count, 100);
  assert_int_equal(nsdae_params_set(&table, &s, "name", "", NULL), NSDAE_OK);
  assert_string_equal(s.name, "");
}

/* Refused with this status, its key in the record, and nothing changed. */
static void refused(const char *key, const char *value, int status, const char *says)
{
  sample s = filled(), before = s;
  nsdae_error error;
  assert_int_equal(nsdae_params_set(&table, &s, key, value, &error), status);
  assert_int_equal(nsdae_params_set(&table, &s, key, value, NULL), status);
  assert_memory_equal(&s, &before, sizeof s);
  assert_int_equal(error.status, status);
  if (key && value) assert_string_equal(error.argument, key);
  if (!strstr(error.text, says)) fail_msg("'%s' does not say '%s'", error.text, says);
  if (strncmp(says, "unknown", 7) == 0) assert_string_equal(error.text, says); /* and no more */
  assert_null(strchr(error.text, '\n'));
}

static void test_not_a_number(void **state)
{
  (void)state;
  const char *const bad[] = {"", " ", "x", "1x", "1 ", "1,5", "1e", "--1", "1.0.0", "0x", "one"};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    refused("any", bad[i], NSDAE_E_ARGUMENT, "not a number");
    refused("count", bad[i], NSDAE_E_ARGUMENT, "not a number");
  }
  refused("bound", "-inf", NSDAE_E_ARGUMENT, "greater than 0");
  refused("bound", "nan", NSDAE_E_ARGUMENT, "greater than 0");
  const char *const broken[] = {"1.5", "0.9999", "1e10", "-3e9"};
  for (size_t i = 0; i < sizeof broken / sizeof *broken; i++)
    refused("count", broken[i], NSDAE_E_ARGUMENT, "whole number");
}

static void test_not_finite(void **state)
{
  (void)state;
  const char *const bad[] = {"nan", "-nan", "inf", "-inf", "infinity", "1e999", "-1e999"};
  const char *const keys[] = {"length", "angle", "fraction", "any", "count"};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++)
      refused(keys[k], bad[i], NSDAE_E_ARGUMENT, "outside its range");
  refused("length", "inf", NSDAE_E_ARGUMENT, "must be finite and greater than 0");
  refused("any", "inf", NSDAE_E_ARGUMENT, "must be a finite number");
}

static void accepted(const char *key, const char *value)
{
  sample s = filled();
  assert_int_equal(nsdae_params_set(&table, &s, key, value, NULL), NSDAE_OK);
  assert_int_equal(nsdae_params_check(&table, &s, NULL), NSDAE_OK);
}

static void test_ranges(void **state)
{
  (void)state;
  refused("length", "0", NSDAE_E_ARGUMENT, "greater than 0");
  refused("length", "-1e-300", NSDAE_E_ARGUMENT, "greater than 0");
  accepted("length", "1e-300");
  accepted("length", "1e300");
  refused("angle", "-1.0000001", NSDAE_E_ARGUMENT, "at least -1 and less than 1");
  refused("angle", "1", NSDAE_E_ARGUMENT, "less than 1");
  accepted("angle", "-1");
  accepted("angle", "0.9999999");
  refused("fraction", "0", NSDAE_E_ARGUMENT, "greater than 0 and less than 1");
  refused("fraction", "1", NSDAE_E_ARGUMENT, "greater than 0 and less than 1");
  accepted("fraction", "1e-9");
  accepted("any", "-1e308");
  refused("count", "0", NSDAE_E_ARGUMENT, "at least 1 and at most 1000");
  refused("count", "1001", NSDAE_E_ARGUMENT, "at most 1000");
  accepted("count", "1");
  accepted("count", "1000");
}

static void test_check_names_the_field(void **state)
{
  (void)state;
  sample s = filled();
  nsdae_error error;
  s.fraction = NAN;
  assert_int_equal(nsdae_params_check(&table, &s, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "fraction");
  s = filled();
  s.colour = 3;
  assert_int_equal(nsdae_params_check(&table, &s, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "colour");
  s.count = 0; /* of two, the first */
  assert_int_equal(nsdae_params_check(&table, &s, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "count");
  s = filled();
  s.length = INFINITY;
  assert_int_equal(nsdae_params_check(&table, &s, NULL), NSDAE_E_ARGUMENT);
}

static void test_unknown(void **state)
{
  (void)state;
  refused("lenght", "1", NSDAE_E_OPTION, "did you mean 'length'?");
  refused("Count", "1", NSDAE_E_OPTION, "did you mean 'count'?");
  refused("lengt", "1", NSDAE_E_OPTION, "did you mean 'length'?");
  refused("opneing", "1", NSDAE_E_OPTION, "did you mean 'angle' (half the opening of it)?");
  refused("open", "1", NSDAE_E_OPTION, "did you mean 'angle' (half the opening of it)?");
  refused("speeding", "1", NSDAE_E_OPTION, "unknown name 'speeding'"); /* three of eight */
  refused("of", "1", NSDAE_E_OPTION, "unknown name 'of'");
  refused("qqqqqqqqqq", "1", NSDAE_E_OPTION, "unknown name 'qqqqqqqqqq'");
  refused("", "1", NSDAE_E_OPTION, "unknown name ''");
  refused("colour", "bleu", NSDAE_E_OPTION, "did you mean 'blue'?");
  refused("colour", "xyzzyx", NSDAE_E_OPTION, "red, green, blue");
  refused("colour", "1", NSDAE_E_OPTION, "red, green, blue");
  refused("colour", NULL, NSDAE_E_ARGUMENT, "NULL");
  refused(NULL, "1", NSDAE_E_ARGUMENT, "NULL");
  assert_null(nsdae_params_find(&table, "nothing"));
  assert_ptr_equal(nsdae_params_find(&table, "count"), &entries[4]);
}

/* The record holds a part of a key or value that is longer than it. */
static void test_long_words(void **state)
{
  (void)state;
  char word[2000];
  sample s = filled();
  nsdae_error error;
  memset(word, 'w', sizeof word - 1);
  word[sizeof word - 1] = '\0';
  assert_int_equal(nsdae_params_set(&table, &s, word, "1", &error), NSDAE_E_OPTION);
  assert_int_equal(nsdae_params_set(&table, &s, "colour", word, &error), NSDAE_E_OPTION);
  assert_int_equal(nsdae_params_set(&table, &s, "any", word, &error), NSDAE_E_ARGUMENT);
  assert_true(strlen(error.text) < sizeof error.text);
}

static void test_text_too_long(void **state)
{
  (void)state;
  char text[NSDAE_PARAM_TEXT_SIZE + 1];
  sample s = filled();
  memset(text, 'a', sizeof text - 1);
  text[sizeof text - 1] = '\0';
  refused("name", text, NSDAE_E_ARGUMENT, "longer than 255");
  text[NSDAE_PARAM_TEXT_SIZE - 1] = '\0';
  assert_int_equal(nsdae_params_set(&table, &s, "name", text, NULL), NSDAE_OK);
  assert_string_equal(s.name, text);
}

static void round_trip(const char *key, sample *from)
{
  char text[NSDAE_PARAM_TEXT_SIZE];
  sample to = filled();
  const nsdae_param *param = nsdae_params_find(&table, key);
  nsdae_params_format(param, from, text, sizeof text);
  assert_int_equal(nsdae_params_set(&table, &to, key, text, NULL), NSDAE_OK);
  nsdae_params_set(&table, &to, "name", from->name, NULL);
  assert_memory_equal((char *)&to + param->offset, (char *)from + param->offset,
                      param->type == NSDAE_PARAM_REAL ? sizeof(double) : sizeof(int));
}

static void test_format(void **state)
{
  (void)state;
  const double awkward[] = {0.0,
                            -0.0,
                            0.1,
                            1.0 / 3,
                            DBL_MIN,
                            DBL_MAX,
                            -DBL_MAX,
                            5e-324,
                            1e23,
                            8.5e22,
                            9007199254740993.0,
                            1e-7,
                            2.2250738585072011e-308,
                            3.141592653589793,
                            1 + DBL_EPSILON,
                            1 - DBL_EPSILON / 2,
                            123456.7,
                            1234567.8};
  for (size_t i = 0; i < sizeof awkward / sizeof *awkward; i++) {
    sample s = filled();
    s.any = awkward[i];
    round_trip("any", &s);
  }
  for (int i = 0; i < 1000; i++) { /* bit patterns spread over all exponents */
    sample s = filled();
    uint64_t bits = 0x9e3779b97f4a7c15u * (uint64_t)(i + 1);
    memcpy(&s.any, &bits, sizeof bits);
    if (isfinite(s.any)) round_trip("any", &s);
  }
  for (int colour = 0; colour < 3; colour++) {
    sample s = filled();
    s.colour = colour;
    s.count = 1 + 333 * colour;
    round_trip("colour", &s);
    round_trip("count", &s);
  }
}

static void test_format_reads_well(void **state)
{
  (void)state;
  char text[64];
  sample s = filled();
  nsdae_params_format(&entries[1], &s, text, sizeof text);
  assert_string_equal(text, "0.1");
  nsdae_params_format(&entries[5], &s, text, sizeof text);
  assert_string_equal(text, "green");
  nsdae_params_set(&table, &s, "name", "where it is", NULL);
  nsdae_params_format(&entries[6], &s, text, sizeof text);
  assert_string_equal(text, "where it is");
  nsdae_params_format(&entries[6], &s, text, 6); /* cut, but a text */
  assert_string_equal(text, "where");
}

/* A locale that has nothing but a decimal comma, made here in a folder of its own: few machines
 * have one installed. */
static const char *comma(void)
{
  const char *const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "es_ES.UTF-8", "de_DE", "fr_FR"};
  char folder[] = "/tmp/nsdae_locale_XXXXXX", source_name[64], command[256];
  assert_non_null(mkdtemp(folder));
  snprintf(source_name, sizeof source_name, "%s/comma.src", folder);
  FILE *source = fopen(source_name, "w");
  assert_non_null(source);
  fputs("LC_NUMERIC\ndecimal_point \",\"\nthousands_sep \"\"\ngrouping -1\nEND LC_NUMERIC\n",
        source);
  fclose(source);
  snprintf(command, sizeof command,
           "localedef -c -i %s -f ANSI_X3.4-1968 %s/comma_C >/dev/null 2>&1", source_name, folder);
  int made = system(command);
  if (made != -1) setenv("LOCPATH", folder, 1);
  const char *in = setlocale(LC_NUMERIC, "comma_C");
  unsetenv("LOCPATH");
  for (size_t i = 0; i < sizeof names / sizeof *names && !in; i++)
    in = setlocale(LC_NUMERIC, names[i]);
  snprintf(command, sizeof command, "rm -r %s", folder);
  assert_int_equal(system(command), 0);
  return in;
}

/* A program in a locale with a decimal comma reads and writes what all others do. */
static void test_decimal_comma(void **state)
{
  (void)state;
  const char *in = comma();
  if (!in || strcmp(localeconv()->decimal_point, ",") != 0) {
    setlocale(LC_NUMERIC, "C");
    untested("localedef makes no locale");
  }
  sample s = filled();
  char text[64];
  assert_int_equal(nsdae_params_set(&table, &s, "angle", "0.25", NULL), NSDAE_OK);
  assert_true(s.angle == 0.25);
  assert_int_equal(nsdae_params_set(&table, &s, "angle", "0,5", NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_params_set(&table, &s, "angle", "0.5.5", NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_params_set(&table, &s, "angle", ".", NULL), NSDAE_E_ARGUMENT);
  char digits[300];
  memset(digits, '0', sizeof digits);
  digits[299] = '\0';
  assert_int_equal(nsdae_params_set(&table, &s, "angle", digits, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_params_set(&table, &s, "count", "12", NULL), NSDAE_OK);
  assert_true(s.angle == 0.25 && s.count == 12);
  nsdae_params_format(&entries[1], &s, text, sizeof text);
  assert_string_equal(text, "0.25");
  assert_int_equal(nsdae_params_set(&table, &s, "length", "2.5e-3", NULL), NSDAE_OK);
  assert_true(s.length == 2.5e-3);
  setlocale(LC_NUMERIC, "C");
}

/* One bound alone, in words and in a refusal. */
static void test_one_bound(void **state)
{
  (void)state;
  typedef struct one {
    double low, high;
  } one;
  const nsdae_param bounds[] = {
      {"low", "", "", NSDAE_PARAM_REAL, offsetof(one, low), 3, 2, INFINITY, 0, NULL},
      {"high", "", "", NSDAE_PARAM_REAL, offsetof(one, high), 3, -INFINITY, 4, NSDAE_OPEN_MAX,
       NULL}};
  const nsdae_params both = {bounds, 2};
  one o;
  nsdae_error error;
  nsdae_params_default(&both, &o);
  assert_int_equal(nsdae_params_check(&both, &o, &error), NSDAE_OK);
  o.high = 4;
  assert_int_equal(nsdae_params_check(&both, &o, &error), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error.text, "it must be less than 4"));
  o.high = -INFINITY;
  assert_int_equal(nsdae_params_check(&both, &o, &error), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error.text, "it must be finite and less than 4"));
  o.high = 3, o.low = 1;
  assert_int_equal(nsdae_params_check(&both, &o, &error), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error.text, "it must be at least 2"));
}

/* What is not there is named, and changes nothing. */
static void test_missing(void **state)
{
  (void)state;
  sample s = filled(), before = s;
  nsdae_error error;
  nsdae_params_default(NULL, &s);
  nsdae_params_default(&table, NULL);
  assert_memory_equal(&s, &before, sizeof s);
  assert_null(nsdae_params_find(NULL, "any"));
  assert_null(nsdae_params_find(&table, NULL));
  assert_int_equal(nsdae_params_check(NULL, &s, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "table");
  assert_int_equal(nsdae_params_check(&table, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "base");
  for (int i = 0; i < 4; i++) {
    const void *given[4] = {&table, &s, "count", "3"};
    const char *const names[4] = {"table", "base", "key", "value"};
    given[i] = NULL;
    assert_int_equal(
        nsdae_params_set(given[0], (void *)(uintptr_t)given[1], given[2], given[3], &error),
        NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, names[i]);
  }
}

/* Functions without a status: nothing, or an empty text. */
static void test_missing_without_status(void **state)
{
  (void)state;
  sample s = filled();
  char text[32] = "before";
  const char *const none[] = {NULL};
  nsdae_params_range(NULL, text, sizeof text);
  assert_string_equal(text, "");
  nsdae_params_range(&entries[0], NULL, sizeof text);
  nsdae_params_range(&entries[0], NULL, 0);
  strcpy(text, "before");
  nsdae_params_format(NULL, &s, text, sizeof text);
  assert_string_equal(text, "");
  strcpy(text, "before");
  nsdae_params_format(&entries[0], NULL, text, sizeof text);
  assert_string_equal(text, "");
  nsdae_params_format(&entries[0], &s, NULL, sizeof text);
  nsdae_params_format(&entries[0], &s, NULL, 0);
  assert_null(nsdae_suggest_name(NULL, colours));
  assert_null(nsdae_suggest_name("red", NULL));
  assert_null(nsdae_suggest_name("red", none));
}

/* Tables whose pointers are NULL, and a choice that there is not. */
static void test_damaged_tables(void **state)
{
  (void)state;
  sample s = filled(), before = s;
  nsdae_error error;
  char text[32];
  nsdae_param entry[3] = {entries[4], entries[5], entries[0]};
  const nsdae_params hollow = {NULL, 3}, damaged = {entry, 3};
  nsdae_params_default(&hollow, &s);
  assert_memory_equal(&s, &before, sizeof s);
  assert_null(nsdae_params_find(&hollow, "count"));
  assert_int_equal(nsdae_params_check(&hollow, &s, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_params_set(&hollow, &s, "count", "3", &error), NSDAE_E_ARGUMENT);
  for (int i = 0; i < 2; i++) {
    memcpy(entry, (const nsdae_param[]){entries[4], entries[5], entries[0]}, sizeof entry);
    if (i == 0) entry[0].key = NULL;
    if (i == 1) entry[1].choices = NULL;
    assert_int_equal(nsdae_params_check(&damaged, &s, &error), NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, i == 0 ? "key" : "choices");
    assert_int_equal(nsdae_params_set(&damaged, &s, "colour", "red", &error), NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, i == 0 ? "key" : "choices");
    nsdae_params_range(&entry[i], text, sizeof text);
    assert_string_equal(text, "");
    nsdae_params_format(&entry[i], &s, text, sizeof text);
    assert_string_equal(text, "");
    assert_non_null(nsdae_params_find(&damaged, "length"));
  }
  entry[0] = entries[4];
  entry[0].help = NULL;
  entry[1] = entries[5];
  assert_int_equal(nsdae_params_set(&damaged, &s, "number of them", "3", &error), NSDAE_E_OPTION);
  s.colour = 3;
  nsdae_params_format(&entry[1], &s, text, sizeof text);
  assert_string_equal(text, "");
  s.colour = -1;
  nsdae_params_format(&entry[1], &s, text, sizeof text);
  assert_string_equal(text, "");
}

/* Hyphens of a choice may be underscores; nothing else is like it. */
static void test_spellings(void **state)
{
  (void)state;
  static const char *const words[] = {"no", "as-it-is", "as", NULL};
  static const nsdae_param entry = {"word", "", "", NSDAE_PARAM_CHOICE, 0, 0, 0, 2, 0, words};
  const nsdae_params one = {&entry, 1};
  const char *const same[] = {"as-it-is", "as_it_is", "as_it-is"};
  const char *const other[] = {"as it is", "as_it", "as_it_is_", "as_", "-no", "_", ""};
  int choice;
  for (int i = 0; i < 3; i++) {
    choice = 0;
    assert_int_equal(nsdae_params_set(&one, &choice, "word", same[i], NULL), NSDAE_OK);
    assert_int_equal(choice, 1);
  }
  for (int i = 0; i < 7; i++)
    assert_int_equal(nsdae_params_set(&one, &choice, "word", other[i], NULL), NSDAE_E_OPTION);
  assert_int_equal(nsdae_params_set(&one, &choice, "word", "as", NULL), NSDAE_OK);
  assert_int_equal(choice, 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_spellings),
      cmocka_unit_test(test_one_bound),
      cmocka_unit_test(test_missing),
      cmocka_unit_test(test_missing_without_status),
      cmocka_unit_test(test_damaged_tables),
      cmocka_unit_test(test_defaults),
      cmocka_unit_test(test_range_in_words),
      cmocka_unit_test(test_set_each_type),
      cmocka_unit_test(test_not_a_number),
      cmocka_unit_test(test_not_finite),
      cmocka_unit_test(test_ranges),
      cmocka_unit_test(test_check_names_the_field),
      cmocka_unit_test(test_unknown),
      cmocka_unit_test(test_long_words),
      cmocka_unit_test(test_text_too_long),
      cmocka_unit_test(test_format),
      cmocka_unit_test(test_format_reads_well),
      cmocka_unit_test(test_decimal_comma),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
