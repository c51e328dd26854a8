/* The options of pictures by name: what the program's command line, sweeps of charts and other languages' interfaces
 * share. One table says of every option its name, type, range, default, when it applies, its exact value and its cost.
 * Plain memory; any thread, one at a time on one set of options.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_OPTIONS_H
#define SIDERAY_OPTIONS_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sideray_option_type {
  SIDERAY_OPTION_SWITCH = 0,  /* "on" or "off", which are its `choices` */
  SIDERAY_OPTION_CHOICE = 1,  /* one of `choices` */
  SIDERAY_OPTION_INTEGER = 2, /* minimum..maximum, or one of `choices` */
  SIDERAY_OPTION_NUMBER = 3,  /* minimum..maximum, or one of `choices` */
  SIDERAY_OPTION_SIZE = 4,    /* "1280x720": sides of minimum..maximum */
  SIDERAY_OPTION_TEXT = 5,    /* not read by the library: for programs that load scenes */
  SIDERAY_OPTION_FLAG = 6,    /* "true" or "false" */
  SIDERAY_OPTION_TYPE_FORCE_32 = 0x7fffffff
} sideray_option_type;

/* What an option costs or saves. */
typedef enum sideray_option_cost {
  SIDERAY_COST_NONE = 0,   /* neither time nor accuracy */
  SIDERAY_COST_PICTURE = 1, /* what is shown: another picture, not a better or a worse one */
  SIDERAY_COST_TRADE = 2,  /* trades time for accuracy */
  SIDERAY_COST_FORCE_32 = 0x7fffffff
} sideray_option_cost;

/* One row of the table. It lives for ever; rows grow at their end. */
typedef struct sideray_option {
  const char* name;        /* "cache-rate" */
  const char* part;        /* the struct of sideray_render_options that holds it: "translucency"; "" = itself */
  sideray_option_type type;
  const char* placeholder; /* for help: "N|auto|unlimited"; "" for switches and choices */
  const char* const* choices;
  size_t choice_count;
  double minimum, maximum;   /* INTEGER, NUMBER and SIZE */
  const char* default_value; /* with `quality` balanced; "" = decided by other options or the scene */
  const char* applies;       /* in words, when it has an effect: "hybrid"; "" = always */
  const char* exact_value;   /* the value without a shortcut; "" = it is none */
  sideray_option_cost cost;
  const char* help; /* one line */
  /* A switch for comparison and measurement: a comparator of chapter 50 of Ray Tracing Gems II, or a check. The program
   * reads it by --diagnose NAME=VALUE and has no switch of its own for it. */
  int32_t diagnostic;
  int32_t advanced;  /* 1: the short help of the program leaves it out */
  const char* group; /* the title above it in help: "Translucency" */
} sideray_option;

/* All options, in the order of docs/cli.md. NULL behind the last. */
SIDERAY_API size_t sideray_option_count(void);
SIDERAY_API const sideray_option* sideray_option_at(size_t index);
/* NULL where there is none of that name. */
SIDERAY_API const sideray_option* sideray_option_find(const char* name);
/* The value that an option, or a value of an option, of version 0.2 is read as until 0.4: "full" of "cache-rate" with the
 * value "temporal4", "" where it has no effect any more; valid for ever. NULL where neither is so. Whoever shows options warns
 * where it is not NULL; sideray_options_set accepts them. */
SIDERAY_API const char* sideray_option_read_as(const char* name, const char* value);
/* What to write instead of an option that version 0.2 had and this one has not, or, where `value` is not NULL, instead
 * of that value of an option that is still there: a text that is valid for ever. NULL where nothing was removed. */
SIDERAY_API const char* sideray_option_removed(const char* name, const char* value);

typedef struct sideray_options sideray_options;

/* A set of options, each at its default. The caller's; release with sideray_options_release. */
SIDERAY_API sideray_status sideray_options_create(sideray_options** options, sideray_error* error);
SIDERAY_API sideray_status sideray_options_copy(const sideray_options* options, sideray_options** copy,
                                                sideray_error* error);
SIDERAY_API void sideray_options_release(sideray_options* options); /* NULL is allowed */

/* Gives an option a value, as text. Fails, changing nothing, with a message that begins with the option's name and says
 * what it accepts; contradictions between options are found by sideray_options_check. NULL or "" gives the default
 * back. */
SIDERAY_API sideray_status sideray_options_set(sideray_options* options, const char* name, const char* value,
                                               sideray_error* error);
/* The value that counts, the default included; "" where it is decided elsewhere, NULL where there is no such option.
 * Valid until the option is set again. */
SIDERAY_API const char* sideray_options_get(const sideray_options* options, const char* name);
/* 1 where the option was set, and not only has its default. */
SIDERAY_API int32_t sideray_options_is_set(const sideray_options* options, const char* name);
/* 1 where the way of drawing that was chosen reads the option, whether its value makes a difference or not: statistics
 * of a picture name these. */
SIDERAY_API int32_t sideray_options_reads(const sideray_options* options, const char* name);
/* 1 where the option has an effect beside the values of the others; `reason` (may be NULL) is why, or why not: a text
 * that is valid for ever. */
SIDERAY_API int32_t sideray_options_applies(const sideray_options* options, const char* name, const char** reason);
struct sideray_scene_facts; /* plan.h */

/* Gives the default back to every option that makes no difference in a scene of these facts, beside the others, and to
 * one of several values that draw the same there: two sets that are equal then draw the same picture. */
SIDERAY_API sideray_status sideray_options_reduce(sideray_options* options, const struct sideray_scene_facts* facts,
                                                  sideray_error* error);
/* 1 where both give every option the same value. */
SIDERAY_API int32_t sideray_options_equal(const sideray_options* a, const sideray_options* b);

/* How pictures of a sequence depend on those before them. 1 was a value of version 0.2. */
typedef enum sideray_past {
  SIDERAY_PAST_NONE = 0,
  SIDERAY_PAST_AVERAGED = 2, /* pictures or masks are averaged over frames: each frame needs its own random numbers */
  SIDERAY_PAST_FORCE_32 = 0x7fffffff
} sideray_past;

SIDERAY_API sideray_past sideray_options_past(const sideray_options* options);
/* Refuses options that contradict each other. The message begins with the name of one of them, and has the other in
 * single quotes: "reference: contradicts 'layers', which it decides itself; leave one of them out". */
SIDERAY_API sideray_status sideray_options_check(const sideray_options* options, sideray_error* error);

/* A shortcut that pictures may take, and what switches it off. */
typedef struct sideray_option_value {
  const char* name;
  const char* value;
} sideray_option_value;

typedef struct sideray_shortcut {
  const char* name; /* one word: "rate" */
  int32_t taken;
  const char* text;                     /* what is done, and what instead; not taken: why nothing is lost by it */
  const sideray_option_value* exactly;  /* the options that switch it off; none where only `is_random` is left */
  size_t exactly_count;
  int32_t is_random; /* without it the picture is a mean over random numbers */
} sideray_shortcut;

typedef struct sideray_shortcuts sideray_shortcuts;

/* The shortcuts of these options in a scene of these facts: those taken, and those that might be. The list is the
 * caller's; its entries live as long as it does. */
SIDERAY_API sideray_status sideray_shortcuts_create(const sideray_options* options,
                                                    const struct sideray_scene_facts* facts,
                                                    sideray_shortcuts** shortcuts, sideray_error* error);
SIDERAY_API size_t sideray_shortcuts_count(const sideray_shortcuts* shortcuts);
SIDERAY_API const sideray_shortcut* sideray_shortcuts_at(const sideray_shortcuts* shortcuts, size_t index);
SIDERAY_API void sideray_shortcuts_release(sideray_shortcuts* shortcuts); /* NULL is allowed */

/* The same as structs, for sideray_renderer_render and sideray_plan_create. It points into `options` and is valid until
 * these are changed or released. */
SIDERAY_API const sideray_render_options* sideray_options_render(const sideray_options* options);

#ifdef __cplusplus
}
#endif
#endif
