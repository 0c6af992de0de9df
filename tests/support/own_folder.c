/* Each process of a test works in a folder of its own, below the current one: two runs of a test do
 * not write the same files. The folder is removed at the end, and stays if the test crashes. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char folder[] = "test-XXXXXX";
static pid_t owner; /* a process that the test forks ends earlier */

static void leave(void)
{
  if (getpid() != owner) return;
  DIR *files = opendir(".");
  for (struct dirent *file; files && (file = readdir(files));)
    remove(file->d_name); /* "." and ".." stay: they are not empty, or in use */
  if (files) closedir(files);
  if (chdir("..") == 0) rmdir(folder);
}

__attribute__((constructor)) static void enter(void)
{
  if (!mkdtemp(folder) || chdir(folder) != 0) {
    perror("a folder for the files of this test");
    exit(1);
  }
  owner = getpid();
  atexit(leave);
}
