/* Numbers by name. The key `let` at the top of a scene names numbers:
 *
 *     let: {speed: 50, half: 0.5*$speed}
 *
 * and a value without quotes, anywhere in the file, may then be an expression
 *
 *     [-] FACTOR {(* | /) FACTOR},   FACTOR = $NAME or a number
 *
 * with at least one $NAME, a name being a letter and then letters, digits and _. A value of `let`
 * may be one of those names that stand before it. Every name must be used. Only a value in quotes
 * holds a $ as a text. */
#ifndef DL_SCENE_LET_H
#define DL_SCENE_LET_H

#include "driftlab/scene.h"
#include "io/yaml.h"

/* Puts numbers in the place of the document's expressions; *let [*lets] is the caller's, NULL where
 * the document has no `let`. DL_INPUT names file, line and what was expected. */
dl_status dl_let_apply(dl_yaml *yaml, size_t *lets, dl_named_number **let, dl_error *error);

/* The document's text with other numbers in its `let`, and after its name what was set:
 * "NAME(a=1)". *text is the caller's. */
dl_status dl_let_replace(const dl_yaml *yaml, size_t count, const dl_let *let, char **text,
                         dl_error *error);

#endif
