#define _POSIX_C_SOURCE 200809L
#include "ratio.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* A string of JSON; titles are of printable ASCII. */
static void put_text(FILE *file, const char *text)
{
  putc('"', file);
  for (; *text; text++) {
    if (*text == '"' || *text == '\\') putc('\\', file);
    putc(*text, file);
  }
  putc('"', file);
}

static void put_entry(FILE *file, const char *title, double ours, const char *peer, double peers)
{
  fputs("  {\"case\": ", file);
  put_text(file, title);
  fprintf(file, ", \"ours_us\": %.6g, \"peer\": ", 1e6 * ours);
  put_text(file, peer);
  fprintf(file, ", \"peer_us\": %.6g, \"ratio\": %.6g}", 1e6 * peers, peers / ours);
}

/* To where the next entry goes, before the bracket that ends the list; the list is begun where the
 * file is new. */
static void find_end(FILE *file)
{
  static const char end[] = "\n]\n";
  if (fseek(file, 0, SEEK_END) == 0 && ftell(file) <= (long)sizeof end) {
    rewind(file);
    fputs("[\n", file);
  } else {
    fseek(file, -(long)(sizeof end - 1), SEEK_END);
    fputs(",\n", file);
  }
}

static int is_time(double seconds)
{
  return isfinite(seconds) && seconds > 0;
}

int ratio_add(const char *title, double ours, const char *peer, double peers)
{
  const char *path = getenv("NSDAE_BENCH_JSON");
  if (!path || !*path || !is_time(ours) || !is_time(peers)) return 0;
  FILE *file = fopen(path, "r+");
  if (!file) file = fopen(path, "w");
  if (!file) return -1;
  find_end(file);
  put_entry(file, title, ours, peer, peers);
  fputs("\n]\n", file);
  int failed = ferror(file);
  return fclose(file) != 0 || failed ? -1 : 0;
}

static int ascending(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double ratio_median(int count, double *a)
{
  qsort(a, (size_t)count, sizeof *a, ascending);
  return count % 2 ? a[count / 2] : (a[count / 2 - 1] + a[count / 2]) / 2;
}

double ratio_cpu(void)
{
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
