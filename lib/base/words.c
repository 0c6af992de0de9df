#include "words.h"

#include <limits.h>
#include <locale.h>
#include <nsdae/params.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vector.h"

enum { LONGEST = 63 }; /* longer names are compared by their beginning */

/* Levenshtein's distance, by its recurrence over one row (Wagner and Fischer, J. ACM 21, 1974). */
static int edit_distance(const char *a, const char *b)
{
  int row[LONGEST + 1];
  int na = nsdae_fewer((int)strlen(a), LONGEST), nb = nsdae_fewer((int)strlen(b), LONGEST);
  for (int j = 0; j <= nb; j++) row[j] = j;
  for (int i = 1; i <= na; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= nb; j++) {
      int change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = nsdae_fewer(change, nsdae_fewer(row[j], row[j - 1]) + 1);
    }
  }
  return row[nb];
}

/* The dashes of an option say nothing of its name. */
static const char *bare(const char *name)
{
  return name + strspn(name, "-");
}

/* A beginning is one change away: "out" is rather "output" than "dt". */
static int distance_between(const char *word, const char *name)
{
  size_t length = strlen(word);
  int begins = length > 1 && length < strlen(name) && strncmp(word, name, length) == 0;
  return begins ? 1 : edit_distance(word, name);
}

nsdae_suggest nsdae_suggest_start(const char *word)
{
  return (nsdae_suggest){.word = word, .name = NULL, .distance = INT_MAX};
}

void nsdae_suggest_try(nsdae_suggest *nearest, const char *name)
{
  int distance = distance_between(bare(nearest->word), bare(name));
  if (distance >= nearest->distance) return;
  nearest->distance = distance;
  nearest->name = name;
}

const char *nsdae_suggest_end(const nsdae_suggest *nearest)
{
  int length = (int)strlen(bare(nearest->word));
  return nearest->distance <= (length + 1) / 2 ? nearest->name : NULL;
}

const char *nsdae_suggest_name(const char *word, const char *const *names)
{
  if (!word || !names) return NULL;
  nsdae_suggest nearest = nsdae_suggest_start(word);
  for (; *names; names++) nsdae_suggest_try(&nearest, *names);
  return nsdae_suggest_end(&nearest);
}

/* strtod and snprintf use the decimal point of the locale, which belongs to the whole program and
 * is not the library's to change: it is exchanged in the text. */

/* The first `from` in text becomes `to`; 0 where there is no room for it. */
static int exchange(char *text, size_t size, const char *from, const char *to)
{
  char *at = strstr(text, from);
  size_t before = strlen(from), after = strlen(to);
  if (!at) return 1;
  if (strlen(text) - before + after >= size) return 0;
  memmove(at + after, at + before, strlen(at + before) + 1);
  memcpy(at, to, after);
  return 1;
}

static int all_read(const char *text, double *value)
{
  char *end;
  *value = strtod(text, &end);
  return end != text && *end == '\0';
}

int nsdae_number_read(const char *text, double *value)
{
  const char *point = localeconv()->decimal_point;
  char local[256];
  if (strcmp(point, ".") == 0) return all_read(text, value);
  if (strstr(text, point) || strlen(text) >= sizeof local) return 0;
  strcpy(local, text);
  return exchange(local, sizeof local, ".", point) && all_read(local, value);
}

void nsdae_number_write(double value, char *text, size_t size)
{
  for (int digits = 6; digits <= 17; digits++) {
    snprintf(text, size, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }
  exchange(text, size, localeconv()->decimal_point, ".");
}
