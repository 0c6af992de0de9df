/* The bytes of a file, to put them back. */
#ifndef NSDAE_TESTS_FILE_IMAGE_H
#define NSDAE_TESTS_FILE_IMAGE_H

typedef struct file_image {
  char *bytes;
  long length;
} file_image;

file_image file_image_read(const char *name);

/* A new file; one of that name is removed. */
void file_image_write(const char *name, const file_image *image);

/* Into the file that is there, which another may have open: what differs is written. */
void file_image_restore(const char *name, const file_image *image);

void file_image_release(file_image *image);

#endif
