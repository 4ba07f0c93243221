//! The derive `SceneData`: see `lightwell::files::SceneData`.

use proc_macro2::{Span, TokenStream};
use quote::quote;
use syn::{Attribute, Data, DeriveInput, Error, Expr, Field, Fields, Lit, Meta, Result, Variant, parse_macro_input};

/// Makes values of a struct or enum loadable from scene files, saved, and editable in the inspector with the help,
/// unit and range that their documentation comments give.
///
/// A struct takes what a file does not say from its `Default`. Attributes of `serde` on fields and variants hold.
#[proc_macro_derive(SceneData, attributes(serde))]
pub fn scene_data(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand(&input).unwrap_or_else(Error::into_compile_error).into()
}

fn expand(input: &DeriveInput) -> Result<TokenStream> {
    if !input.generics.params.is_empty() {
        let message = "`SceneData` cannot be derived for a generic type: scene files name types, and this is many";
        return Err(Error::new_spanned(&input.generics, message));
    }
    let (ident, name) = (&input.ident, input.ident.to_string());
    let (mirror, defaults) = mirror(input)?;
    let notes = notes(input, &name);
    let types = field_types(input);
    let default = defaults.then(|| quote!(, default = "__default"));
    let default_fn = defaults.then(|| {
        quote!(
            fn __default() -> #ident {
                ::core::default::Default::default()
            }
        )
    });
    Ok(quote! {
        const _: () = {
            use lightwell::__private::serde as __serde;

            #[allow(dead_code)]
            #[derive(__serde::Serialize, __serde::Deserialize)]
            #[serde(crate = "lightwell::__private::serde", remote = #name, rename = #name, deny_unknown_fields #default)]
            #mirror

            #default_fn

            impl __serde::Serialize for #ident {
                fn serialize<S: __serde::Serializer>(&self, serializer: S) -> ::core::result::Result<S::Ok, S::Error> {
                    __Mirror::serialize(self, serializer)
                }
            }
            impl<'de> __serde::Deserialize<'de> for #ident {
                fn deserialize<D: __serde::Deserializer<'de>>(
                    deserializer: D,
                ) -> ::core::result::Result<Self, D::Error> {
                    __Mirror::deserialize(deserializer)
                }
            }
            impl lightwell::files::SceneData for #ident {
                const NAME: &'static str = #name;
                fn describe(notes: &mut ::std::vec::Vec<lightwell::files::TypeNote>) {
                    use lightwell::__private::{OfAnything as _, OfSceneData as _};
                    if notes.iter().any(|note| note.key == #name) {
                        return;
                    }
                    #(notes.push(lightwell::files::TypeNote { key: #notes });)*
                    #((&lightwell::__private::Probe::<#types>::new()).describe(notes);)*
                }
            }
        };
    })
}

/// A type of the same shape for `serde` to derive on, and whether missing fields take their default.
fn mirror(input: &DeriveInput) -> Result<(TokenStream, bool)> {
    match &input.data {
        Data::Struct(data) => {
            let fields = &data.fields;
            let body = match fields {
                Fields::Named(fields) => {
                    let fields = fields.named.iter().map(mirror_field);
                    quote!({ #(#fields),* })
                }
                Fields::Unnamed(fields) => {
                    let fields = fields.unnamed.iter().map(mirror_field);
                    quote!(( #(#fields),* );)
                }
                Fields::Unit => quote!(;),
            };
            Ok((quote!(struct __Mirror #body), matches!(fields, Fields::Named(f) if !f.named.is_empty())))
        }
        Data::Enum(data) => {
            let variants = data.variants.iter().map(mirror_variant);
            Ok((quote!(enum __Mirror { #(#variants),* }), false))
        }
        Data::Union(_) => {
            let message = "`SceneData` cannot be derived for a union: use a struct or an enum";
            Err(Error::new(Span::call_site(), message))
        }
    }
}

fn mirror_field(field: &Field) -> TokenStream {
    let (attributes, ty) = (serde_attributes(&field.attrs), &field.ty);
    match &field.ident {
        Some(ident) => quote!(#(#attributes)* #ident: #ty),
        None => quote!(#(#attributes)* #ty),
    }
}

fn mirror_variant(variant: &Variant) -> TokenStream {
    let (attributes, ident) = (serde_attributes(&variant.attrs), &variant.ident);
    let fields = variant.fields.iter().map(mirror_field);
    match &variant.fields {
        Fields::Named(_) => quote!(#(#attributes)* #ident { #(#fields),* }),
        Fields::Unnamed(_) => quote!(#(#attributes)* #ident ( #(#fields),* )),
        Fields::Unit => quote!(#(#attributes)* #ident),
    }
}

fn serde_attributes(attributes: &[Attribute]) -> impl Iterator<Item = &Attribute> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("serde"))
}

/// `key: "Type.field", help: "…"` of the type and all its parts that have a comment.
fn notes(input: &DeriveInput, name: &str) -> Vec<TokenStream> {
    let mut notes = vec![note(name, &comment(&input.attrs))];
    let mut field = |scope: &str, field: &Field| {
        if let Some(ident) = &field.ident {
            notes.push(note(&format!("{scope}.{ident}"), &comment(&field.attrs)));
        }
    };
    match &input.data {
        Data::Struct(data) => data.fields.iter().for_each(|f| field(name, f)),
        Data::Enum(data) => {
            for variant in &data.variants {
                variant.fields.iter().for_each(|f| field(&format!("{name}.{}", variant.ident), f));
            }
            for variant in &data.variants {
                notes.push(note(&format!("{name}.{}", variant.ident), &comment(&variant.attrs)));
            }
        }
        Data::Union(_) => {}
    }
    notes
}

fn note(key: &str, help: &str) -> TokenStream {
    quote!(#key, help: #help)
}

/// The documentation comment on one line.
fn comment(attributes: &[Attribute]) -> String {
    let line = |attribute: &Attribute| {
        let Meta::NameValue(meta) = &attribute.meta else { return None };
        let Expr::Lit(literal) = &meta.value else { return None };
        let Lit::Str(text) = &literal.lit else { return None };
        meta.path.is_ident("doc").then(|| text.value().trim().to_owned())
    };
    attributes.iter().filter_map(line).collect::<Vec<_>>().join(" ").trim().to_owned()
}

fn field_types(input: &DeriveInput) -> Vec<&syn::Type> {
    match &input.data {
        Data::Struct(data) => data.fields.iter().map(|field| &field.ty).collect(),
        Data::Enum(data) => data.variants.iter().flat_map(|v| &v.fields).map(|field| &field.ty).collect(),
        Data::Union(_) => Vec::new(),
    }
}
