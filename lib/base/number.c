/* strtod and snprintf use the decimal point of the locale, which belongs to the whole program and
 * is not the library's to change: it is exchanged in the text. */
#include "number.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
