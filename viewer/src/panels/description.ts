/** What the server says about its fields: their kinds, defaults and what they mean. */

import type { Client, api } from "piad";

/** A JSON schema, as far as it is read here. */
export interface Schema {
  readonly $ref?: string;
  readonly type?: string | readonly string[];
  readonly enum?: readonly unknown[];
  readonly const?: unknown;
  readonly description?: string;
  readonly properties?: Readonly<Record<string, Schema>>;
  readonly oneOf?: readonly Schema[];
  readonly anyOf?: readonly Schema[];
}

/** What somebody may write into a field. */
export interface Kind {
  readonly choices: readonly string[];
  readonly number: boolean;
  readonly boolean: boolean;
  /** Lists or objects. */
  readonly more: boolean;
  /** One value for each direction of a surface. */
  readonly pair: boolean;
}

export interface Parameter {
  readonly name: string;
  readonly in: string;
  readonly description?: string;
  readonly schema: Schema;
}

interface Root {
  readonly components: {
    readonly schemas: Readonly<Record<string, Schema>>;
    readonly parameters: Readonly<Record<string, Parameter>>;
  };
  readonly paths: Readonly<Record<string, Readonly<Record<string, Operation>>>>;
}

interface Operation {
  readonly parameters?: readonly (Parameter | { readonly $ref: string })[];
  readonly responses: Readonly<Record<string, { readonly content?: Readonly<Record<string, { readonly schema: Schema }>> }>>;
}

const known = new WeakMap<Client, Promise<Description>>();

/** The description of the API and what this server can do. */
export class Description {
  readonly capabilities: api.Capabilities;
  readonly #root: Root;

  private constructor(root: unknown, capabilities: api.Capabilities) {
    this.#root = root as Root;
    this.capabilities = capabilities;
  }

  /** Asked once; again after a failure. */
  static of(client: Client): Promise<Description> {
    const kept = known.get(client);
    if (kept !== undefined) return kept;
    const asked = Promise.all([client.description(), client.capabilities()]).then(([root, capabilities]) => new Description(root, capabilities));
    known.set(client, asked);
    asked.catch(() => known.delete(client));
    return asked;
  }

  schema(name: string): Schema {
    return this.#root.components.schemas[name] ?? {};
  }

  /** A field of a schema. */
  field(name: string, field: string): Schema {
    return this.schema(name).properties?.[field] ?? {};
  }

  /** What a field may be, through all references. */
  kind(schema: Schema): Kind {
    const kinds = this.#alternatives(schema);
    const types = kinds.flatMap(({ type }) => type ?? []);
    const pair = kinds.some(({ properties }) => properties !== undefined && Object.keys(properties).join() === "u,v");
    return {
      choices: kinds.flatMap((kind) => (kind.const === undefined ? (kind.enum ?? []) : [kind.const])).filter((value) => typeof value === "string"),
      number: types.includes("number") || types.includes("integer"),
      boolean: types.includes("boolean"),
      more: types.includes("array") || kinds.some(({ type, properties }) => type === "object" && Object.keys(properties ?? {}).join() !== "u,v"),
      pair,
    };
  }

  /** What a field means: its own words, else those of its type. */
  help(schema: Schema): string {
    const words = schema.description ?? this.#alternatives(schema).find(({ description }) => description !== undefined)?.description ?? "";
    return plain(words);
  }

  /** What a field is when it is not given, as it is written. */
  usual(schema: Schema): string {
    const words = [schema, ...this.#through(schema)].map(({ description }) => description ?? "");
    for (const text of words) {
      const found = /Default: `"?([^`"]+)"?`/.exec(text)?.[1];
      if (found !== undefined) return found;
    }
    return "";
  }

  /** The kinds that the description of a schema lists, with their names and what they are. */
  titles(name: string): ReadonlyMap<string, { readonly title: string; readonly help: string }> {
    const lines = (this.schema(name).description ?? "").matchAll(/^- `(\w+)`: ([^.]+)\. (.*)$/gm);
    return new Map([...lines].map(([, kind = "", title = "", help = ""]) => [kind, { title, help: plain(help) }]));
  }

  /** The parameters of a path that are no part of it. */
  parameters(path: string): Parameter[] {
    const all = this.#root.paths[path]?.["get"]?.parameters ?? [];
    return all.flatMap((one) => ("$ref" in one ? (this.#root.components.parameters[last(one.$ref)] ?? []) : one)).filter((one) => one.in === "query");
  }

  /** The values that a part of a path may have. */
  parts(name: string): string[] {
    return [...this.kind(this.#root.components.parameters[name]?.schema ?? {}).choices];
  }

  /** The media types of the answers of a path, with what they are. */
  media(path: string): [string, string][] {
    const content = this.#root.paths[path]?.["get"]?.responses["200"]?.content ?? {};
    return Object.entries(content).map(([type, { schema }]) => [type, plain(schema.description ?? "")]);
  }

  #through(schema: Schema): Schema[] {
    const inner = [...(schema.oneOf ?? []), ...(schema.anyOf ?? [])];
    const named = schema.$ref === undefined ? [] : [this.schema(last(schema.$ref))];
    return [...inner, ...named].flatMap((part) => [part, ...this.#through(part)]);
  }

  #alternatives(schema: Schema): Schema[] {
    return [schema, ...this.#through(schema)].filter((part) => part.oneOf === undefined && part.anyOf === undefined && part.$ref === undefined);
  }
}

function last(ref: string): string {
  return ref.slice(ref.lastIndexOf("/") + 1);
}

/** Words without marks, line breaks and lists. */
function plain(words: string): string {
  return words.split("\n\n")[0]!.replace(/\s*Default: `[^`]*`\.?/, "").replace(/\s*Only with (`\w+`(, )?)+\./, "").replace(/ \(\d{3}\)/g, "").replace(/[`]/g, "").replace(/_/g, " ").replace(/\s+/g, " ").trim();
}

/** Words as a sentence. */
export function sentence(words: string): string {
  return words.charAt(0).toUpperCase() + words.slice(1) + (/[.!?]$/.test(words) ? "" : ".");
}

/** A name of a field as people write it. */
export function spoken(name: string): string {
  const words = name.replace(/_/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}
