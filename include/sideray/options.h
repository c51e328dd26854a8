/* The options of pictures by name, shared by the program's command line, the sweeps of charts and interfaces of other
 * languages. One table has each option's name, type, range, default, condition of use, exact value and cost. Plain
 * memory; any thread, but only one at a time on one set of options.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_OPTIONS_H
#define SIDERAY_OPTIONS_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sideray_option_type {
  SIDERAY_OPTION_SWITCH = 0,  /* "on" or "off", which are also its `choices` */
  SIDERAY_OPTION_CHOICE = 1,  /* one of `choices` */
  SIDERAY_OPTION_INTEGER = 2, /* minimum..maximum, or one of `choices` */
  SIDERAY_OPTION_NUMBER = 3,  /* minimum..maximum, or one of `choices` */
  SIDERAY_OPTION_SIZE = 4,    /* "1280x720": sides within minimum..maximum */
  SIDERAY_OPTION_TEXT = 5,    /* ignored by the library; for programs that load scenes */
  SIDERAY_OPTION_FLAG = 6,    /* "true" or "false" */
  SIDERAY_OPTION_TYPE_FORCE_32 = 0x7fffffff
} sideray_option_type;

/* Says what an option trades. */
typedef enum sideray_option_cost {
  SIDERAY_COST_NONE = 0,   /* neither time nor accuracy */
  SIDERAY_COST_PICTURE = 1, /* changes what is shown, not how well */
  SIDERAY_COST_TRADE = 2,  /* trades time for accuracy */
  SIDERAY_COST_FORCE_32 = 0x7fffffff
} sideray_option_cost;

/* One row of the table. It is valid for ever; rows grow at their end. */
typedef struct sideray_option {
  const char* name;        /* "cache-rate" */
  const char* part;        /* its struct within sideray_render_options: "translucency"; "" = in none of these */
  sideray_option_type type;
  const char* placeholder; /* for help: "N|auto|unlimited"; "" for switches and choices */
  const char* const* choices;
  size_t choice_count;
  double minimum, maximum;   /* INTEGER, NUMBER and SIZE */
  const char* default_value; /* with `quality` balanced; "" = decided by other options or the scene */
  const char* applies;       /* when it has an effect, in words: "hybrid"; "" = always */
  const char* exact_value;   /* the value that switches a shortcut off; "" = it is no shortcut */
  sideray_option_cost cost;
  const char* help; /* one line */
  /* A switch for comparison and measurement: a comparator of chapter 50 of Ray Tracing Gems II, or a check. The program
   * has no switch for it and reads it by --diagnose NAME=VALUE. */
  int32_t diagnostic;
  int32_t advanced;  /* 1: omitted in the program's short help */
  const char* group; /* its heading in help: "Translucency" */
} sideray_option;

/* Return the options in the order of docs/cli.md, and their number. NULL for an index beyond the last. */
SIDERAY_API size_t sideray_option_count(void);
SIDERAY_API const sideray_option* sideray_option_at(size_t index);
/* Returns NULL if there is no option of that name. */
SIDERAY_API const sideray_option* sideray_option_find(const char* name);
/* Returns the replacement, valid until 0.4, for a value or option of version 0.2: for example "full" for "cache-rate"
 * with the value "temporal4", or "" for an option that no longer has an effect. NULL: nothing is replaced. The text is
 * valid for ever. sideray_options_set accepts replaced values; programs should warn about them. */
SIDERAY_API const char* sideray_option_read_as(const char* name, const char* value);
/* Returns a text that says what to write instead of an option that version 0.2 had and this one lacks, or, if `value`
 * is not NULL, instead of that removed value of an option. Valid for ever. NULL: nothing was removed. */
SIDERAY_API const char* sideray_option_removed(const char* name, const char* value);

typedef struct sideray_options sideray_options;

/* Creates a set of options with their defaults. The caller owns it and releases it by sideray_options_release. */
SIDERAY_API sideray_status sideray_options_create(sideray_options** options, sideray_error* error);
SIDERAY_API sideray_status sideray_options_copy(const sideray_options* options, sideray_options** copy,
                                                sideray_error* error);
SIDERAY_API void sideray_options_release(sideray_options* options); /* NULL is allowed */

/* Sets an option to a value given as text; NULL or "" restores the default. A failure changes nothing; its message
 * begins with the option's name and says what it accepts. Contradictions between options are found by
 * sideray_options_check. */
SIDERAY_API sideray_status sideray_options_set(sideray_options* options, const char* name, const char* value,
                                               sideray_error* error);
/* Returns the value in use, which may be the default; "" if other options or the scene decide it, NULL if there is no
 * such option. Valid until the option is set again. */
SIDERAY_API const char* sideray_options_get(const sideray_options* options, const char* name);
/* Returns 1 if the option was set, 0 if it has its default. */
SIDERAY_API int32_t sideray_options_is_set(const sideray_options* options, const char* name);
/* Returns 1 if the chosen way of drawing reads the option, even if its value makes no difference. The statistics of a
 * picture list these options. */
SIDERAY_API int32_t sideray_options_reads(const sideray_options* options, const char* name);
/* Returns 1 if the option has an effect together with the values of the others. `reason` (may be NULL) receives why or
 * why not: a text that is valid for ever. */
SIDERAY_API int32_t sideray_options_applies(const sideray_options* options, const char* name, const char** reason);
struct sideray_scene_facts; /* plan.h */

/* Restores the default of every option that makes no difference in a scene with these facts, given the others, and
 * replaces values that draw the same picture there by one of them. Sets that are then equal draw the same picture. */
SIDERAY_API sideray_status sideray_options_reduce(sideray_options* options, const struct sideray_scene_facts* facts,
                                                  sideray_error* error);
/* Returns 1 if all options have equal values in both sets. */
SIDERAY_API int32_t sideray_options_equal(const sideray_options* a, const sideray_options* b);

/* How pictures of a sequence depend on earlier ones. The value 1 was used in version 0.2. */
typedef enum sideray_past {
  SIDERAY_PAST_NONE = 0,
  SIDERAY_PAST_AVERAGED = 2, /* pictures or masks are averaged over frames, which need different random numbers */
  SIDERAY_PAST_FORCE_32 = 0x7fffffff
} sideray_past;

SIDERAY_API sideray_past sideray_options_past(const sideray_options* options);
/* Refuses options that contradict each other. The message begins with the name of one of them and has the other in
 * single quotes: "reference: contradicts 'layers', which it decides itself; leave one of them out". */
SIDERAY_API sideray_status sideray_options_check(const sideray_options* options, sideray_error* error);

/* Describes a shortcut that pictures may take, and what switches it off. */
typedef struct sideray_option_value {
  const char* name;
  const char* value;
} sideray_option_value;

typedef struct sideray_shortcut {
  const char* name; /* one word: "rate" */
  int32_t taken;
  const char* text;                     /* what it does, and instead of what; if not taken: why it loses nothing */
  const sideray_option_value* exactly;  /* options that switch it off; none if only `is_random` is left */
  size_t exactly_count;
  int32_t is_random; /* without it, the picture is a mean over random numbers */
} sideray_shortcut;

typedef struct sideray_shortcuts sideray_shortcuts;

/* Lists the shortcuts of these options in a scene with these facts: those taken, and those that might be. The caller
 * owns the list; its entries live as long as it does. */
SIDERAY_API sideray_status sideray_shortcuts_create(const sideray_options* options,
                                                    const struct sideray_scene_facts* facts,
                                                    sideray_shortcuts** shortcuts, sideray_error* error);
SIDERAY_API size_t sideray_shortcuts_count(const sideray_shortcuts* shortcuts);
SIDERAY_API const sideray_shortcut* sideray_shortcuts_at(const sideray_shortcuts* shortcuts, size_t index);
SIDERAY_API void sideray_shortcuts_release(sideray_shortcuts* shortcuts); /* NULL is allowed */

/* Returns the options as structs for sideray_renderer_render and sideray_plan_create. They point into `options` and are
 * valid until these are changed or released. */
SIDERAY_API const sideray_render_options* sideray_options_render(const sideray_options* options);

#ifdef __cplusplus
}
#endif
#endif
