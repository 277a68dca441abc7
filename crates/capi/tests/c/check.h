/* What the calls share. */

#ifndef CHECK_H
#define CHECK_H

#include <punctual.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                                               \
  do {                                                                                                                 \
    if (!(condition)) {                                                                                                \
      fprintf(stderr, "%s:%d: not so: %s (last error: %s)\n", __FILE__, __LINE__, #condition, punctual_last_error());  \
      exit(1);                                                                                                         \
    }                                                                                                                  \
  } while (0)
#define OK(call) CHECK((call) == PUNCTUAL_STATUS_OK)
#define FAILS(call, status, text) CHECK((call) == PUNCTUAL_STATUS_##status && strcmp(punctual_last_error(), text) == 0)

/** In rays.c. */
void rays(void);

/** In robots.c. */
void robots(void);

/** In scene_calls.c. */
void scene_answers(void);

/** In versions.c. */
void versions(void);

#endif
