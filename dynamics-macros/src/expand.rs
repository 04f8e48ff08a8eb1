//! The expansion: the model's module, and what makes the struct behave like it.

use crate::attribute::Attributes;
use crate::door::{self, Module};
use crate::forward::Forward;
use crate::input::{Input, Number, Variable};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote, quote_spanned};
use syn::{DeriveInput, Error, Generics, Result, parse_quote};

/// Expands `#[derive(Dynamics)]`.
pub fn expand(item: &DeriveInput) -> Result<TokenStream> {
    let input = Input::of(item)?;
    let attributes = Attributes::of(item)?;
    let place = attributes.model.span();
    let module = door::open(&attributes, &input)?;
    let file: syn::File = syn::parse_str(&module.text)
        .map_err(|error| Error::new(place, format!("the emitted module is no Rust: {error}")))?;
    let system = System::new(item, &input, &module);
    let forward = Forward::of(&file, &system)
        .ok_or_else(|| Error::new(place, "the emitted module implements no `System`"))?;

    let dependencies = dependencies(&module, place)?;
    let warnings = warnings(&module.warnings, place);
    let items = &file.items;
    let name = system.module();
    let conversion = system.conversion(&forward);
    let nominal = system.nominal();
    let implementation = forward.implementation(&system);
    let inherent = forward.inherent(&system, &nominal);
    Ok(quote! {
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::restriction)]
        const _: () = {
            #dependencies
            mod #name { #(#items)* }
            #conversion
            #implementation
            #inherent
        };
        #warnings
    })
}

/// The struct that becomes a system.
pub struct System<'a> {
    item: &'a DeriveInput,
    number: &'a Number,
    variables: &'a [Variable],
    /// Names of the parameters in the emitted module.
    fields: Vec<Ident>,
}

impl<'a> System<'a> {
    fn new(item: &'a DeriveInput, input: &'a Input, module: &Module) -> Self {
        let identifier = |name: &String| Ident::new(name, Span::call_site());
        Self {
            item,
            number: &input.number,
            variables: &input.variables,
            fields: module.fields.iter().map(identifier).collect(),
        }
    }

    /// The name of the module inside the expansion.
    pub fn module(&self) -> Ident {
        format_ident!("__dynamics_of_{}", self.item.ident)
    }

    /// The number type of methods: the struct's own, or `T`.
    pub fn scalar(&self) -> Ident {
        match self.number {
            Number::Generic(ident) => ident.clone(),
            Number::Floats => Ident::new("T", Span::call_site()),
        }
    }

    /// Whether the number type is a parameter of the struct.
    pub fn is_generic(&self) -> bool {
        matches!(self.number, Number::Generic(_))
    }

    /// The function that turns the struct into the model.
    pub fn model(&self) -> Ident {
        format_ident!("__model_of_{}", self.item.ident)
    }

    /// Generics with the number type's bound, for an `impl` of something per number type.
    pub fn generics(&self) -> Generics {
        let mut generics = self.item.generics.clone();
        let scalar = self.scalar();
        if !self.is_generic() {
            generics.params.push(parse_quote!(#scalar));
        }
        for parameter in generics.type_params_mut() {
            parameter.default = None;
            parameter.bounds.push(parse_quote!(::dynamics::Scalar));
        }
        generics
    }

    /// The generics of an inherent `impl`, which must not have parameters of its own.
    pub fn own_generics(&self) -> Generics {
        if self.is_generic() {
            self.generics()
        } else {
            self.item.generics.clone()
        }
    }

    /// The struct with its parameters, as in `impl … for this`.
    pub fn this(&self) -> TokenStream {
        let name = &self.item.ident;
        let (_, arguments, _) = self.item.generics.split_for_impl();
        quote!(#name #arguments)
    }

    /// `fn model(this: &Cart<T>) -> module::Cartpole<T>`
    fn conversion(&self, forward: &Forward) -> TokenStream {
        let (generics, this, function) = (self.generics(), self.this(), self.model());
        let (parameters, _, condition) = generics.split_for_impl();
        let model = forward.model(self);
        let scalar = self.scalar();
        let values = self.variables.iter().map(|variable| {
            let field = &variable.field;
            match (self.is_generic(), variable.single) {
                (true, _) => quote!(this.#field),
                (false, false) => quote!(<#scalar as ::dynamics::Scalar>::from_f64(this.#field)),
                (false, true) => {
                    quote!(<#scalar as ::dynamics::Scalar>::from_f64(f64::from(this.#field)))
                }
            }
        });
        let fields = &self.fields;
        quote! {
            #[inline(always)]
            fn #function #parameters(this: &#this) -> #model #condition {
                let mut model = <#model>::nominal();
                #(model.parameters.#fields = #values;)*
                model
            }
        }
    }

    /// `fn nominal() -> Self`; a struct without fields needs none.
    fn nominal(&self) -> TokenStream {
        if self.variables.is_empty() {
            return TokenStream::new();
        }
        let module = self.module();
        let values = self
            .variables
            .iter()
            .zip(&self.fields)
            .map(|(variable, name)| {
                let (field, ty) = (&variable.field, &variable.ty);
                quote!(#field: #module::Parameters::<#ty>::nominal().#name)
            });
        quote! {
            /// With the values that the model's file states.
            pub fn nominal() -> Self {
                Self { #(#values),* }
            }
        }
    }
}

/// Makes cargo build anew when one of the files changes.
fn dependencies(module: &Module, place: Span) -> Result<TokenStream> {
    let mut lines = TokenStream::new();
    for file in &module.files {
        let absolute = std::path::absolute(file).unwrap_or_else(|_| file.clone());
        let path = absolute.to_str().ok_or_else(|| {
            let message = format!("the path `{}` is not UTF-8 text", absolute.display());
            Error::new(place, message)
        })?;
        lines.extend(quote!(
            const _: &[u8] = ::core::include_bytes!(#path);
        ));
    }
    Ok(lines)
}

/// A macro cannot warn; the use of something deprecated can.
fn warnings(rendered: &str, place: Span) -> TokenStream {
    if rendered.is_empty() {
        return TokenStream::new();
    }
    let note = format!("the model has this to say\n\n{rendered}\n");
    quote_spanned! {place=>
        const _: () = {
            #[deprecated(note = #note)]
            const MODEL: () = ();
            MODEL
        };
    }
}
