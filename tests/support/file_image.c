#include "file_image.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static void fail(const char *name)
{
  perror(name);
  abort();
}

file_image file_image_read(const char *name)
{
  struct stat status;
  FILE *file = fopen(name, "rb");
  if (!file || fstat(fileno(file), &status) != 0) fail(name);
  file_image image = {malloc((size_t)status.st_size + 1), (long)status.st_size};
  if (!image.bytes) fail(name);
  if (fread(image.bytes, 1, (size_t)image.length, file) != (size_t)image.length) fail(name);
  fclose(file);
  return image;
}

void file_image_write(const char *name, const file_image *image)
{
  remove(name);
  file_image_restore(name, image);
}

/* Most of a large file is as it was: a page that is equal is not written. */
void file_image_restore(const char *name, const file_image *image)
{
  enum { PAGE = 4096 };
  const size_t length = (size_t)image->length;
  int file = open(name, O_RDWR | O_CREAT, 0666);
  if (file < 0 || truncate(name, image->length) != 0) fail(name);
  char *now = length ? mmap(NULL, length, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : NULL;
  if (now == MAP_FAILED) fail(name);
  for (size_t at = 0; at < length; at += PAGE) {
    const size_t size = length - at < PAGE ? length - at : PAGE;
    if (memcmp(now + at, image->bytes + at, size) != 0) memcpy(now + at, image->bytes + at, size);
  }
  if (now) munmap(now, length);
  close(file);
}

void file_image_release(file_image *image)
{
  free(image->bytes);
  image->bytes = NULL;
}
