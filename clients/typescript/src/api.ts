/** The types of the API, by their names in the OpenAPI document. */

import type { operations } from "./description.js";

export type * from "./description.js";

/** The query parameters of an operation. */
export type Query<Name extends keyof operations> = NonNullable<operations[Name]["parameters"]["query"]>;
